"""laserscan_to_pointcloud_node beside stock's laser_geometry, with which the original makes its points."""

from __future__ import annotations

import json
import random
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from harness import STOCK_PYTHON

from pyros1.msgs.sensor_msgs.msg import LaserScan
from pyros1.robot_nodes.pointcloud_to_laserscan.projection import unproject

pytestmark = [
    pytest.mark.ours_only,
    pytest.mark.skipif(
        not Path("/usr/lib/python3/dist-packages/laser_geometry").exists(),
        reason="python3-laser-geometry is not installed; run interop/setup",
    ),
]

STOCK = """
import json, sys
from laser_geometry import LaserProjection
from sensor_msgs.msg import LaserScan
from sensor_msgs.point_cloud2 import read_points
for line in sys.stdin:
    cloud = LaserProjection().projectLaser(LaserScan(**json.loads(line)))
    names = [field.name for field in cloud.fields]
    print(json.dumps([names, [list(point) for point in read_points(cloud)]]))
"""
OUTSIDE = [float("nan"), float("inf"), -float("inf"), -1.0, 0.0, 10.0, 99.0]


def random_scan(chance: random.Random) -> dict[str, Any]:
    count = chance.choice([1, 5, 90, 360])
    ranges = [chance.choice([chance.uniform(0.5, 9.9), chance.uniform(0.5, 9.9), *OUTSIDE]) for _ in range(count)]
    start, step = chance.uniform(-3.1, 0.0), chance.choice([0.0087, 0.05, -0.02])
    return {
        "angle_min": start,
        "angle_max": start + step * (count - 1),
        "angle_increment": step,
        "range_min": 0.5,
        "range_max": 10.0,
        "ranges": ranges,
        "intensities": [chance.uniform(0, 255) for _ in ranges],
    }


def test_the_same_points() -> None:
    chance = random.Random(5)
    scans = [random_scan(chance) for _ in range(40)]
    lines = "".join(json.dumps(scan) + "\n" for scan in scans)
    said = subprocess.run(
        [STOCK_PYTHON, "-c", STOCK], input=lines, capture_output=True, text=True, timeout=60, check=False
    )
    assert said.returncode == 0, said.stderr
    answers = said.stdout.splitlines()
    assert len(answers) == len(scans)
    for scan, answer in zip(scans, answers, strict=True):
        names, points = json.loads(answer)
        ours = unproject(LaserScan(**scan))
        assert set(names) == set(ours)
        stocks = np.array(points, float).reshape(-1, len(names))
        for column, name in enumerate(names):
            np.testing.assert_allclose(ours[name], stocks[:, column], atol=1e-5, err_msg=name)
