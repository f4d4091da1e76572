"""The state of a joystick, and the schedule for publishing it."""

from __future__ import annotations

from dataclasses import dataclass

from pyros1.robot_nodes.joy.events import AXIS, FULL_SCALE, Event

MAX_DEADZONE = 0.9


@dataclass(frozen=True)
class Settings:
    """Rules for converting a joystick's events to messages; see https://wiki.ros.org/joy.

    Attributes:
        deadzone: how far an axis must be from the centre to count, as a fraction from 0 to `MAX_DEADZONE`.
        autorepeat_rate: the rate in Hz at which the state is published while nothing changes; 0 for never.
        coalesce_interval: seconds to wait for events of other axes after an axis event.
        use_initial_axes: whether to use the positions that the device reports when it is opened. Otherwise, axes are 0
            until they are moved, since some devices report nonsense.
        sticky_buttons: whether each press toggles a button between 0 and 1; otherwise, a button is 1 while pressed.
    """

    deadzone: float = 0.05
    autorepeat_rate: float = 0.0
    coalesce_interval: float = 0.001
    use_initial_axes: bool = False
    sticky_buttons: bool = False


class Joystick:
    """The axes and buttons of a joystick that may be unplugged at any time.

    Buttons are published at once, so that no press is lost. Axes, and the state that the device reports when it is
    opened, are published ``coalesce_interval`` after the first event. Times are in seconds.

    When the joystick is unplugged, one state with all axes and buttons 0 is published, and nothing afterwards: a robot
    that is driven with an enable button must stop, even if nobody repeats the last state.

    Attributes:
        axes: positions from -1 to 1. Left and up are positive, unlike in the events.
        buttons: 0 or 1 each.
    """

    def __init__(self, settings: Settings) -> None:
        self.axes: list[float] = []
        self.buttons: list[int] = []
        self._settings = settings
        self._is_open = False
        self._due: float | None = None  # when to publish a change
        self._last: float | None = None  # when the state was last published
        self._pressed: set[int] = set()
        self._moved: set[int] = set()

    def open(self, axes: int, buttons: int, now: float) -> None:
        """Handle the opening of the device; the numbers of its axes and buttons are 0 if unknown."""
        self.axes, self.buttons = [0.0] * axes, [0] * buttons
        self._is_open = True
        self._due, self._last = None, now
        self._pressed, self._moved = set(), set()

    def close(self, now: float) -> None:
        """Handle the unplugging of the device: release all buttons and centre all axes."""
        if self._is_open:
            self.axes, self.buttons = [0.0] * len(self.axes), [0] * len(self.buttons)
            self._is_open = False
            self._due = now

    def handle(self, event: Event, now: float) -> None:
        """Apply an event."""
        if event.kind == AXIS:
            self._move(event)
        else:
            self._press(event)
        due = now + self._settings.coalesce_interval if event.initial or event.kind == AXIS else now
        self._due = due if self._due is None else min(self._due, due)

    def due(self) -> float | None:
        """Return the time of the next publication; None if it must wait for another event."""
        if self._due is not None or not self._is_open or not self._settings.autorepeat_rate:
            return self._due
        assert self._last is not None
        return self._last + 1 / self._settings.autorepeat_rate

    def published(self, now: float) -> None:
        """Record that the state has been published."""
        self._due, self._last = None, now

    def _move(self, event: Event) -> None:
        self.axes += [0.0] * (event.number + 1 - len(self.axes))
        # The kernel also reports the state after it dropped events; an axis that has been moved must then follow.
        if event.initial and not self._settings.use_initial_axes and event.number not in self._moved:
            return
        if not event.initial:
            self._moved.add(event.number)
        deadzone = self._settings.deadzone
        size = min(1.0, max(0.0, abs(event.value) / FULL_SCALE - deadzone) / (1 - deadzone))
        self.axes[event.number] = -size if event.value > 0 else size

    def _press(self, event: Event) -> None:
        self.buttons += [0] * (event.number + 1 - len(self.buttons))
        was_pressed = event.number in self._pressed
        (self._pressed.add if event.value else self._pressed.discard)(event.number)
        if not self._settings.sticky_buttons:
            self.buttons[event.number] = int(event.value != 0)
        elif event.value and not was_pressed:
            self.buttons[event.number] ^= 1
