"""Decides which gamepad states are published, so that a robot stops when its page is gone."""

from __future__ import annotations

import math
import threading
from typing import Any, NamedTuple

from pyros1.web.server.wire import RequestError

SILENCE = 0.5
"""Seconds without a state from the page after which the gamepad counts as released."""
MAX_AXES, MAX_BUTTONS = 64, 128


class GamepadState(NamedTuple):
    """A gamepad's state, as in sensor_msgs/Joy: axes from -1 to 1, and buttons, 0 or 1 each."""

    axes: list[float]
    buttons: list[int]

    def released(self) -> GamepadState:
        """Return a state of the same size with all axes and buttons at 0."""
        return GamepadState([0.0] * len(self.axes), [0] * len(self.buttons))


def read_state(value: Any) -> GamepadState | None:
    """Return the state that a page has sent; None if the page has released the gamepad.

    Args:
        value: null, or an object with lists of numbers, ``axes`` and ``buttons``.

    Raises:
        RequestError: the value has another form, a number is out of range, or there are too many axes or buttons.
    """
    if value is None:
        return None
    axes, buttons = (value.get("axes"), value.get("buttons")) if isinstance(value, dict) else (None, None)
    if not isinstance(axes, list) or not isinstance(buttons, list):
        raise RequestError("the state of a gamepad must have the lists axes and buttons")
    if len(axes) > MAX_AXES or len(buttons) > MAX_BUTTONS:
        raise RequestError(f"a gamepad can have at most {MAX_AXES} axes and {MAX_BUTTONS} buttons")
    for axis in axes:
        if isinstance(axis, bool) or not isinstance(axis, (int, float)) or not abs(axis) <= 1:
            raise RequestError("axes must be numbers from -1 to 1")
    if any(isinstance(button, bool) or button not in (0, 1) for button in buttons):
        raise RequestError("buttons must be 0 or 1")
    return GamepadState([float(axis) for axis in axes], [int(button) for button in buttons])


class RemoteGamepad:
    """A gamepad whose state comes from a page that may be closed, hidden or cut off at any time.

    The page repeats its state at least every `SILENCE` seconds. When it releases the gamepad, is silent for longer, or
    is closed, a state with all axes and buttons at 0 is published once, and then nothing more. May be used in several
    threads. Times are in seconds.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._state: GamepadState | None = None  # None: the page has released the gamepad
        self._published: GamepadState | None = None  # None: the release has been published
        self._heard_at = -math.inf

    def receive(self, state: GamepadState | None, now: float) -> bool:
        """Store a state from the page, or None if the gamepad was released; return whether to publish at once."""
        with self._lock:
            is_new = state != self._state or now - self._heard_at > SILENCE
            self._state, self._heard_at = state, now
            return is_new

    def take(self, now: float) -> GamepadState | None:
        """Return the state to publish now; None if there is none."""
        with self._lock:
            if now - self._heard_at > SILENCE:
                self._state = None
            if self._state is not None:
                self._published = self._state
                return self._state
            last, self._published = self._published, None
            return last.released() if last is not None else None
