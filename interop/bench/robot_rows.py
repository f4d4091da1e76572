"""The rows of robots' nodes: what each takes of the processor at its usual rate, beside stock's where Debian has it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from harness import STOCK_PYTHON
from model import OURS, ROSCPP, Goal, Row, Step, at_least

if TYPE_CHECKING:
    from steps import Bench

SCRIPT = Path(__file__).resolve().parent / "robot_nodes.py"
IMAGES = "640 x 480, 30 Hz"
LIMITS: Mapping[str, float] = {
    "joy_node: 50 events/s": 3,
    "teleop_twist_joy: 50 Hz": 2,
    "twist_mux: 3 inputs, 20 Hz each": 3,
    "velocity_smoother: 20 Hz": 2,
    "laser_filters: 3 filters, 720 rays, 40 Hz": 5,
    f"depthimage_to_laserscan: {IMAGES}": 6,
    "pointcloud_to_laserscan: 30,000 points, 10 Hz": 6,
    "imu_filter_madgwick: 100 Hz": 5,
    "imu_complementary_filter: 100 Hz": 5,
    "ekf_localization_node: odometry 50 Hz, IMU 100 Hz, output 30 Hz": 10,
    "rosserial_python: IMU 100 Hz": 4,
    "map_server: idle": 0.1,
    "flat_world: 10 robots, 360 rays, 20 Hz": 50,
}
"""The works that Debian's stock has no node for, and how many percent of a core they may take."""
RATIOS: Mapping[str, float] = {
    f"image_proc: rectify bgr8, {IMAGES}": 0.6,
    f"image_proc: rectify mono8, {IMAGES}": 0.5,
    f"image_proc: debayer, {IMAGES}": 0.4,
    f"image_proc: debayer and rectify, {IMAGES}": 0.6,
    "diagnostic_aggregator: 20 items, 1 Hz each": 0.5,
}
"""The others, and how many times better than stock's C++ nodes ours, in Python, have to be."""


@dataclass(frozen=True)
class NodeWork:
    """One work of robot_nodes.py.

    Attributes:
        side: ``ours`` or ``stock``.
        work: its name there.
    """

    side: str
    work: str

    @property
    def label(self) -> str:
        return f"robot_nodes.py {self.side}: {self.work}"

    def run(self, bench: Bench) -> dict[str, float]:
        words = ("--side", self.side, "--work", self.work, "--seconds", str(bench.seconds / 2))
        out = bench.output(STOCK_PYTHON, str(SCRIPT), *words, kind=OURS)
        return {name: float(value) for name, value in json.loads(out.splitlines()[-1]).items()}


def robot_nodes() -> Iterator[Row]:
    """The rows."""
    for work in (*LIMITS, *RATIOS):
        steps: dict[str, Step] = {OURS: NodeWork("ours", work)}
        goals: tuple[Goal, ...] = (Goal(LIMITS[work], most=True),) if work in LIMITS else at_least(RATIOS[work])
        if work in RATIOS:
            steps[ROSCPP] = NodeWork("stock", work)
        yield Row("robot nodes", work, "% of a core", "cpu", steps, goals, less=True)
