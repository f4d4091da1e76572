"""Random laser scans."""

from __future__ import annotations

import math
import random

from pyros1.msgs.sensor_msgs.msg import LaserScan
from pyros1.msgs.std_msgs.msg import Header


def random_scan(seed: int, *, nan: bool = True, size: int | None = None) -> LaserScan:
    """Return a scan with walls, jumps and rays that measured nothing."""
    chance = random.Random(seed)
    count = chance.choice([0, 1, 2, 9, 60]) if size is None else size
    ranges: list[float] = []
    wall = 2.0
    for _ in range(count):
        wall = chance.uniform(0.3, 6.0) if chance.random() < 0.15 else wall + chance.uniform(-0.1, 0.1)
        ranges.append(wall)
        if chance.random() < 0.2:
            ranges[-1] = chance.choice([math.inf, 0.0, 0.05, 8.0, 8.01, -1.0, *([math.nan] if nan else [])])
    if chance.random() < 0.5:
        angle_min, increment = chance.uniform(-3, 0), chance.choice([0.01, 0.1])
    else:
        angle_min, increment = chance.uniform(0, 3), -chance.choice([0.01, 0.1])
    return LaserScan(
        header=Header(frame_id="laser"),
        angle_min=angle_min,
        angle_max=angle_min + increment * max(count - 1, 0),
        angle_increment=increment,
        time_increment=0.001,
        range_min=0.1,
        range_max=8.0,
        ranges=ranges,
        intensities=[chance.uniform(0, 20000) for _ in ranges] if chance.random() < 0.7 else [],
    )
