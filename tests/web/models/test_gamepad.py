"""When a page's gamepad is published, and when everything on it is released."""

from __future__ import annotations

import random
from typing import Any

import pytest

from pyros1.web.models.gamepad import MAX_AXES, SILENCE, GamepadState, RemoteGamepad, read_state
from pyros1.web.server.wire import RequestError

DRIVE = GamepadState([0.0, 1.0], [1])
STILL = GamepadState([0.0, 0.0], [0])


def test_the_last_state_is_repeated_until_the_page_is_silent() -> None:
    gamepad = RemoteGamepad()
    assert gamepad.take(0.0) is None
    assert gamepad.receive(DRIVE, 10.0)
    assert gamepad.take(10.0) == gamepad.take(10.0 + SILENCE) == DRIVE
    assert gamepad.take(10.1 + SILENCE) == STILL
    assert gamepad.take(10.2 + SILENCE) is None
    assert gamepad.receive(DRIVE, 12.0)  # it speaks again
    assert gamepad.take(12.0) == DRIVE


def test_letting_go_is_published_once() -> None:
    gamepad = RemoteGamepad()
    assert not gamepad.receive(None, 0.0) or gamepad.take(0.0) is None
    gamepad.receive(DRIVE, 0.1)
    assert gamepad.take(0.1) == DRIVE
    assert gamepad.receive(None, 0.2)
    assert [gamepad.take(0.2), gamepad.take(0.3)] == [STILL, None]
    assert not gamepad.receive(None, 0.3)


def test_what_is_repeated_is_not_new() -> None:
    gamepad = RemoteGamepad()
    assert [gamepad.receive(state, 0.0) for state in (DRIVE, DRIVE, STILL, STILL)] == [True, False, True, False]


def test_whatever_happens_a_robot_that_was_driven_is_stopped() -> None:
    """Against a simple rule: what was published last is not the page's last word only if it is all 0."""
    chance = random.Random(3)
    for _ in range(300):
        gamepad, now, last, word, heard = RemoteGamepad(), 0.0, None, None, -1e9
        for _ in range(40):
            now += chance.choice((0.01, 0.1, 0.3, 0.7))
            if chance.random() < 0.5:
                word, heard = chance.choice((None, DRIVE, STILL)), now
                gamepad.receive(word, now)
            published = gamepad.take(now)
            wanted = word if now - heard <= SILENCE else None
            if wanted is None:
                word = None
                assert published == (STILL if last is not None else None)
            else:
                assert published == wanted
            last = wanted


NO_AXES: list[Any] = [1.001, -1e9, 10**400, float("nan"), "0", None, True, [0]]
NO_BUTTONS: list[Any] = [2, -1, 0.5, "1", None, True, {}]
NO_STATES: list[Any] = [5, [], "x", {}, {"axes": []}, {"axes": 1, "buttons": []}]
NO_STATES += [{"axes": [axis], "buttons": []} for axis in NO_AXES]
NO_STATES += [{"axes": [], "buttons": [button]} for button in NO_BUTTONS]
NO_STATES += [{"axes": [0] * (MAX_AXES + 1), "buttons": []}, {"axes": [], "buttons": [0] * 1000}]


@pytest.mark.parametrize("value", NO_STATES)
def test_what_is_no_state_is_refused(value: Any) -> None:
    with pytest.raises(RequestError):
        read_state(value)


def test_a_state_is_read() -> None:
    assert read_state(None) is None
    assert read_state({"axes": [-1, 0.5], "buttons": [1, 0]}) == GamepadState([-1.0, 0.5], [1, 0])
