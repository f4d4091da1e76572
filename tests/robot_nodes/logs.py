"""Waiting for what a node logs."""

from __future__ import annotations

import time

import pytest

PATIENCE = 20.0


def wait_for_line(capfd: pytest.CaptureFixture[str], text: str) -> None:
    """Wait until a text appears on stderr, to which nodes log in a thread of their own."""
    until, seen = time.monotonic() + PATIENCE, ""
    while text not in seen:
        assert time.monotonic() < until, f"not logged: {text}, only {seen}"
        time.sleep(0.01)
        seen += capfd.readouterr().err
