"""The command line of ``tests/mutants``."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

DRIVER = Path(__file__).with_name("driver.py")


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        ([], "which rooms?"),
        (["nope"], "no modules in nope"),
        (["/elsewhere/clock.py"], "no modules in /elsewhere/clock.py"),
        (["tests/mutation/test_driver.py"], "no modules in tests/mutation/test_driver.py"),
        (["--at", "src/pyros1/node/clock.py"], "not a file and a line"),
        (["--at", "src/pyros1/node/clock.py:"], "not a file and a line"),
        (["wire", "--jobs", "0"], "not a number above 0: '0'"),
        (["wire", "--sample", "-1"], "not a number above 0: '-1'"),
    ],
)
def test_mistakes_are_errors_before_any_test_runs(words: list[str], complaint: str) -> None:
    command = [sys.executable, str(DRIVER), *words]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert complaint in done.stderr
    assert "Traceback" not in done.stderr
