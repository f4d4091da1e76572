"""The events of Linux's joystick devices (``/dev/input/js*``).

An event has eight bytes: a time in ms, a value, a type and the number of the button or axis. See
https://docs.kernel.org/input/joydev/joystick-api.html.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

from pyros1.ground.errors import Error

BUTTON, AXIS, INIT = 0x01, 0x02, 0x80
"""Types of events. INIT is added to the type of events that report the state of all buttons and axes instead of a
change, after the device was opened or after the kernel had to drop events."""
FULL_SCALE = 32767
"""The value of an axis that is pushed to its end."""

_EVENT = struct.Struct("=IhBB")


class NotAJoystickError(Error):
    """A device sends bytes that are not joystick events."""


class Event(NamedTuple):
    """A button or an axis has a new value.

    Attributes:
        kind: BUTTON or AXIS.
        number: the number of the button or axis, up to 255.
        value: 0 or 1, or -32767 to 32767 for an axis.
        initial: whether the event reports the state rather than a change.
    """

    kind: int
    number: int
    value: int
    initial: bool


class EventReader:
    """Extracts events from the bytes read from a device, in pieces of any size."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes) -> list[Event]:
        """Return the events that are complete now.

        Raises:
            NotAJoystickError: the type of an event is unknown.
        """
        data = self._rest + data
        end = len(data) - len(data) % _EVENT.size
        self._rest = data[end:]
        events = []
        for _, value, type_, number in _EVENT.iter_unpack(data[:end]):
            if type_ & ~INIT not in (BUTTON, AXIS):
                raise NotAJoystickError(f"it sent an event of unknown type {type_}: it is no joystick")
            events.append(Event(type_ & ~INIT, number, value, bool(type_ & INIT)))
        return events
