"""The bytes of joystick devices."""

from __future__ import annotations

import random
import struct

import pytest

from pyros1.robot_nodes.joy.events import AXIS, BUTTON, INIT, Event, EventReader, NotAJoystickError


def packed(event: Event) -> bytes:
    type_ = event.kind | (INIT if event.initial else 0)
    return struct.pack("=IhBB", 123456, event.value, type_, event.number)


def test_events_in_pieces_of_any_size() -> None:
    chance = random.Random(1)
    for _ in range(200):
        events = [
            Event(
                chance.choice([BUTTON, AXIS]),
                chance.randrange(256),
                chance.randrange(-32768, 32768),
                chance.random() < 0.5,
            )
            for _ in range(chance.randrange(20))
        ]
        data = b"".join(map(packed, events))
        reader, found = EventReader(), []
        while data:
            size = chance.randrange(1, 30)
            found += reader.feed(data[:size])
            data = data[size:]
        assert found == events


@pytest.mark.parametrize("type_", [0, 3, 4, INIT, INIT | 3, 0x7F])
def test_what_is_no_event(type_: int) -> None:
    with pytest.raises(NotAJoystickError, match=rf"unknown type {type_}: it is no joystick"):
        EventReader().feed(struct.pack("=IhBB", 0, 0, type_, 0))
