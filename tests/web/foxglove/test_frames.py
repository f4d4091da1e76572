"""Frames that viewers get, where the machine's tests do not see them."""

from __future__ import annotations

from pyros1.web.foxglove import frames


def test_times() -> None:
    assert frames.nanoseconds(1.5) == 1_500_000_000
    assert frames.nanoseconds(-1.0) == 0
    assert frames.nanoseconds(1e12) == (1 << 64) - 1


def test_an_error_of_a_file_may_have_any_characters() -> None:
    assert frames.asset_failure(3, "\ud800")[10:] == b"?"
