"""Frames that viewers get, where the machine's tests do not see them."""

from __future__ import annotations

import pytest
from websockets.frames import Frame, Opcode

from pyros1.web.foxglove import frames


@pytest.mark.parametrize("size", [0, 1, 125, 126, 65_535, 65_536, 100_000])
def test_frames_around_messages_are_those_of_the_library(size: int) -> None:
    data = bytes(size)
    assert frames.websocket_frame(data) == Frame(Opcode.BINARY, data).serialize(mask=False)


def test_times() -> None:
    assert frames.nanoseconds(1.5) == 1_500_000_000
    assert frames.nanoseconds(-1.0) == 0
    assert frames.nanoseconds(1e12) == (1 << 64) - 1


def test_an_error_of_a_file_may_have_any_characters() -> None:
    assert frames.asset_failure(3, "\ud800")[10:] == b"?"
