"""camera_calibration, as Debian's package installs it, on stock's modules and on ours. It needs OpenCV, so both run in
the interpreter of the system, where OpenCV is; PYROS1_ROSPY prefers our modules to stock's.

Feature: camera_calibration without its window -- same results on stock's modules and on ours
"""

from __future__ import annotations

import subprocess
from pathlib import Path

from faces import FACES, environ
from harness import STOCK_PYTHON, Master

MASTERS = ("ours",)
PROGRAM = Path(__file__).parent / "programs" / "calibration.py"


def test_a_camera_is_calibrated_and_checked(master: Master) -> None:
    said = []
    for face in FACES:
        extra = {"PYROS1_ROSPY": "pyros1"} if face == "ours" else {}
        done = subprocess.run(
            [STOCK_PYTHON, "-W", "ignore", str(PROGRAM)],
            env=environ(face, master, **extra),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=100,
            check=False,
        )
        assert done.returncode == 0, f"on {face}: {done.stderr[-3000:]}"
        said.append(done.stdout)
    assert said[0] == said[1]
    assert "Reprojection RMS Error" in said[0] and "set_camera_info" not in said[0]
