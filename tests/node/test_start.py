"""Ctrl-C while a node waits for its master ends the program quietly."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2] / "src"
PROGRAM = "import pyros1; pyros1.Node('early', argv=[])"


def test_ctrl_c_while_waiting_for_the_master(tmp_path: Path) -> None:
    environ = {
        **os.environ,
        "PYTHONPATH": str(SOURCE),
        "PYTHONUNBUFFERED": "1",
        "ROS_HOME": str(tmp_path),
        "ROS_MASTER_URI": "http://localhost:9",
    }
    child = subprocess.Popen(
        [sys.executable, "-c", PROGRAM], env=environ, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    with child:
        assert child.stderr is not None
        assert "master may not be running yet" in child.stderr.readline()
        child.send_signal(signal.SIGINT)
        rest = child.communicate(timeout=20)[1]
    assert child.returncode == 130
    assert "Traceback" not in rest
