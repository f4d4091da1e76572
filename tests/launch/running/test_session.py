"""A master that was started but cannot be reached by its own name is said to be so."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[3] / "src"


def test_unknown_own_name_names_ros_hostname(tmp_path: Path, free_port: int) -> None:
    environ = {
        **os.environ,
        "PYTHONPATH": str(SOURCE),
        "ROS_HOME": str(tmp_path),
        "ROS_HOSTNAME": "nohost.invalid",
        "ROS_MASTER_URI": f"http://nohost.invalid:{free_port}",
    }
    command = [sys.executable, "-m", "pyros1", "core", "-p", str(free_port)]
    done = subprocess.run(command, env=environ, capture_output=True, text=True, timeout=30, check=False)
    assert done.returncode == 1
    assert "cannot be reached at http://nohost.invalid" in done.stderr
    assert "Check ROS_HOSTNAME" in done.stderr and "Traceback" not in done.stderr
