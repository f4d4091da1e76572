"""What is published of a joystick, and when."""

from __future__ import annotations

import random

import pytest

from pyros1.robot_nodes.joy.events import AXIS, BUTTON, Event
from pyros1.robot_nodes.joy.joystick import Joystick, Settings

State = tuple[float, list[float], list[int]]


def press(number: int, value: int = 1, initial: bool = False) -> Event:
    return Event(BUTTON, number, value, initial)


def move(number: int, value: int, initial: bool = False) -> Event:
    return Event(AXIS, number, value, initial)


def run(settings: Settings, schedule: list[tuple[float, Event | str]], end: float) -> list[State]:
    """Return what is published: when, axes and buttons."""
    joystick = Joystick(settings)
    joystick.open(2, 2, 0.0)
    published: list[State] = []

    def publish_until(limit: float) -> None:
        while (due := joystick.due()) is not None and due <= limit:
            published.append((due, list(joystick.axes), list(joystick.buttons)))
            joystick.published(due)

    for time, event in schedule:
        publish_until(time)
        if event == "unplug":
            joystick.close(time)
        elif event == "plug":
            joystick.open(2, 2, time)
        elif isinstance(event, Event):
            joystick.handle(event, time)
        publish_until(time)
    publish_until(end)
    return published


def position(value: int, deadzone: float) -> float:
    """How far an axis is pushed, as the wiki describes it."""
    fraction = value / 32767
    if abs(fraction) <= deadzone:
        return 0.0
    beyond = (abs(fraction) - deadzone) / (1 - deadzone)
    return min(beyond, 1.0) * (-1 if fraction > 0 else 1)


@pytest.mark.parametrize("deadzone", [0.0, 0.05, 0.3, 0.9])
def test_axes(deadzone: float) -> None:
    chance = random.Random(2)
    for value in [-32768, -32767, -1, 0, 1, 32767, *(chance.randrange(-32768, 32768) for _ in range(200))]:
        [(_, axes, _)] = run(Settings(deadzone), [(0.0, move(1, value))], 1.0)
        assert axes == pytest.approx([0.0, position(value, deadzone)])
        assert str(axes[0]) == "0.0" and abs(axes[1]) <= 1


def test_a_button_is_published_at_once_and_axes_together() -> None:
    schedule = [
        (1.0, move(0, -32767)),
        (1.03, move(1, 32767)),
        (2.0, move(0, 0)),
        (2.05, press(1)),
        (2.06, press(1, 0)),
    ]
    assert run(Settings(0.0, coalesce_interval=0.1), [*schedule], 9.0) == [
        (1.1, [1.0, -1.0], [0, 0]),
        (2.05, [0.0, -1.0], [0, 1]),
        (2.06, [0.0, -1.0], [0, 0]),
    ]


def test_what_the_device_reports_when_it_is_opened() -> None:
    schedule = [(0.0, press(0, 1, True)), (0.0, move(0, -32767, True)), (1.0, move(1, -32767))]
    assert run(Settings(), [*schedule], 1.1) == [(0.001, [0.0, 0.0], [1, 0]), (1.001, [0.0, 1.0], [1, 0])]
    assert run(Settings(use_initial_axes=True), [*schedule], 1.1)[0] == (0.001, [1.0, 0.0], [1, 0])


def test_an_axis_follows_when_the_kernel_has_dropped_its_events() -> None:
    schedule = [(1.0, move(0, -32767)), (2.0, move(0, 0, True)), (2.0, move(1, -32767, True))]
    assert [axes for _, axes, _ in run(Settings(), [*schedule], 3.0)] == [[1.0, 0.0], [0.0, 0.0]]


def test_sticky_buttons() -> None:
    presses = [(1.0, press(0)), (2.0, press(0, 0)), (3.0, press(0)), (3.5, press(0, 1, True)), (4.0, press(0, 0))]
    found = run(Settings(sticky_buttons=True), [*presses, (5.0, press(0)), (6.0, "unplug")], 9.0)
    assert [buttons[0] for _, _, buttons in found] == [1, 1, 0, 0, 0, 1, 0]


def test_buttons_and_axes_that_the_device_did_not_announce() -> None:
    published = run(Settings(), [(1.0, press(255)), (2.0, move(3, -32767))], 3.0)
    assert [(len(axes), len(buttons)) for _, axes, buttons in published] == [(2, 256), (4, 256)]
    assert published[-1][1] == [0.0, 0.0, 0.0, 1.0] and published[0][2][255] == 1


def by_the_clock(period: int, interval: int, schedule: list[tuple[int, Event | str]], end: int) -> list[State]:
    """The same as `run`, by looking at each tick what has to be done; a period of 0 means no repetition."""
    published: list[State] = []
    axes, buttons, changed_at, quiet_since, is_open = [0.0, 0.0], [0, 0], -1, 0, True

    def publish(now: int) -> None:
        nonlocal changed_at, quiet_since
        published.append((now, list(axes), list(buttons)))
        changed_at, quiet_since = -1, now

    for now in range(end + 1):
        must_repeat = is_open and period > 0 and now - quiet_since >= period
        if now - changed_at >= interval if changed_at >= 0 else must_repeat:
            publish(now)
        for _, event in [item for item in schedule if item[0] == now]:
            if event == "unplug":
                axes, buttons, is_open = [0.0, 0.0], [0, 0], False
                publish(now)
            elif isinstance(event, Event) and event.kind == BUTTON:
                buttons[event.number] = event.value
            elif isinstance(event, Event):
                axes[event.number] = -event.value / 32767 + 0.0
            if isinstance(event, Event) and event.kind == BUTTON and not event.initial:
                publish(now)
            elif isinstance(event, Event):
                changed_at = now if changed_at < 0 else changed_at
                if now - changed_at >= interval:
                    publish(now)
    return published


def test_random_schedules() -> None:
    chance = random.Random(3)
    for _ in range(300):
        period, interval = chance.choice([0, 4, 16]), chance.choice([0, 1, 3, 10])
        schedule: list[tuple[int, Event | str]] = []
        now = 0
        for _ in range(chance.randrange(1, 20)):
            now += chance.choice([0, 1, 2, 5, 40])
            number, initial = chance.randrange(2), chance.random() < 0.2
            value = chance.choice([-32767, 0, 32767])
            schedule.append(
                (now, chance.choice([press(number, int(value > 0), initial), move(number, value, initial)]))
            )
        now += chance.choice([0, 1, 30])
        schedule.append((now, "unplug"))
        settings = Settings(0.0, 1 / period if period else 0.0, interval, use_initial_axes=True)
        published = run(settings, [*schedule], now + 100)
        assert published == by_the_clock(period, interval, schedule, now + 100)
        assert published[-1] == (now, [0.0, 0.0], [0, 0]), "the last message, and at once"


def test_after_it_is_plugged_in_again() -> None:
    published = run(Settings(0.0, 2.0), [(0.1, press(0)), (0.2, "unplug"), (5.0, "plug"), (5.1, move(0, -32767))], 5.7)
    assert published == [
        (0.1, [0.0, 0.0], [1, 0]),
        (0.2, [0.0, 0.0], [0, 0]),
        (5.101, [1.0, 0.0], [0, 0]),
        (5.601, [1.0, 0.0], [0, 0]),
    ]


def test_what_was_pressed_and_moved_before_does_not_count() -> None:
    before: list[tuple[float, Event | str]] = [(1.0, press(0)), (1.1, move(0, -32767)), (2.0, "unplug")]
    after: list[tuple[float, Event | str]] = [(3.0, "plug"), (3.1, move(0, -32767, True)), (4.0, press(0))]
    published = run(Settings(sticky_buttons=True), [*before, *after], 5.0)
    assert published[-2:] == [(3.101, [0.0, 0.0], [0, 0]), (4.0, [0.0, 0.0], [1, 0])]
