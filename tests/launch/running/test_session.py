"""A master that was started but cannot be reached by its own name is said to be so."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parents[3] / "src"


@pytest.mark.parametrize(("own", "port"), [("nohost.invalid", "-p{}"), ("localhost", "")], ids=["own", "master's"])
def test_a_name_that_is_unknown_is_named(tmp_path: Path, free_port: int, own: str, port: str) -> None:
    environ = {
        **os.environ,
        "PYTHONPATH": str(SOURCE),
        "ROS_HOME": str(tmp_path),
        "ROS_HOSTNAME": own,
        "ROS_MASTER_URI": f"http://nohost.invalid:{free_port}",
    }
    command = [sys.executable, "-m", "pyros1", "core", *filter(None, [port.format(free_port)])]
    done = subprocess.run(command, env=environ, capture_output=True, text=True, timeout=30, check=False)
    assert done.returncode == 1
    assert "cannot be reached at http://nohost.invalid" in done.stderr
    assert "[nohost.invalid] is not a name of this machine" in done.stderr
    assert "Check ROS_HOSTNAME" in done.stderr and "Traceback" not in done.stderr
