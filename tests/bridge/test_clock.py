"""The clock of a bridge."""

from __future__ import annotations

import sys
import time

import pytest

from pyros1.bridge.clock import choose_clock


@pytest.mark.parametrize(("platform", "clock"), [("linux", "CLOCK_BOOTTIME"), ("darwin", "CLOCK_MONOTONIC_RAW")])
def test_the_clock_goes_on_while_the_machine_sleeps(platform: str, clock: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setattr(time, "clock_gettime", lambda number: 5.0 if number == getattr(time, clock) else 0.0)
    assert choose_clock()() == 5.0
