"""Verbs that measure in simulated time say when it stands still."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.cli.commands.topic._stopped_clock import StoppedClockDetector
from pyros1.ground.timing import Time


@pytest.mark.parametrize("simulated", [True, False])
def test_it_is_said_once_until_time_moves(capsys: pytest.CaptureFixture[str], simulated: bool) -> None:
    times = [0, 0, 0, 5, 6, 6]
    node: Any = SimpleNamespace(params={"/use_sim_time": simulated}, now=lambda: Time(times.pop(0), 0))
    standstill = StoppedClockDetector(node, " Press play.")
    expected = [False, True, True, False, False, True] if simulated else [False] * 6
    assert [standstill.warn_if_stopped() for _ in expected] == expected
    text = "WARNING: simulated time has stopped at {:.3f} s. Is /clock being published? Press play.\n"
    assert capsys.readouterr().err == (text.format(0) + text.format(6) if simulated else "")
