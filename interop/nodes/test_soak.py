"""Everything at once for two minutes, while nodes come and go: `interop/soak.py`, which runs by hand for longer.

A minute over TCP, and one with shared memory: a test that takes two minutes counts as one that hangs.

Feature: nothing is lost and nothing leaks while nodes come and go -- topics, services, parameters and bags, ours and
    stock; a ten-minute run by hand: `interop/soak.md`
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

MINUTES = 1.0
FIVE = {"core", "recorder", "player", "talker", "listener"}


@pytest.mark.ours_only
@pytest.mark.parametrize("transports", ["tcp", "local,tcp"])
def test_nothing_is_lost_and_nothing_grows(tmp_path: Path, transports: str) -> None:
    program = Path(__file__).resolve().parents[1] / "soak.py"
    report = tmp_path / "report.json"
    command = [sys.executable, str(program), "--minutes", str(MINUTES), "--json", str(report)]
    environ = {**os.environ, "PYROS1_TRANSPORTS": transports}
    run = subprocess.run(command, env=environ, capture_output=True, text=True, timeout=110, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    told = json.loads(report.read_text(encoding="utf-8"))
    assert {row["process"] for row in told["figures"]} == FIVE
    assert (
        told["visits"]["rospy"] and told["visits"]["roscpp"] and told["visits"]["pyros1"] and told["visits"]["killed"]
    )
    assert told["listener"]["fast"]["dropped"] and told["listener"]["comers"] and told["recorded"]["visits"]
