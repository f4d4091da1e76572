"""What the tests of these nodes share: a joystick to plug in, and callbacks that can be waited for."""

from __future__ import annotations

import os
import struct
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from queue import Queue
from typing import Any

import pytest

PATIENCE = 20.0


class FakeJoystick:
    """A pipe that sends a joystick's events, for the parameter ``~dev``."""

    def __init__(self, path: Path) -> None:
        self.path = str(path)
        self._file: int | None = None

    def plug(self) -> None:
        """Make the device appear."""
        os.mkfifo(self.path)
        # A pipe that is open for reading, too, does not wait for its reader.
        self._file = os.open(self.path, os.O_RDWR)

    def send(self, type_: int, number: int, value: int) -> None:
        """Send an event: of type 1 for a button, 2 for an axis, and 128 more for one of the initial state."""
        self.write(struct.pack("=IhBB", 0, value, type_, number))

    def write(self, data: bytes) -> None:
        """Send bytes."""
        assert self._file is not None
        os.write(self._file, data)

    def unplug(self) -> None:
        """Make the device disappear."""
        if self._file is not None:
            os.unlink(self.path)
            os.close(self._file)
            self._file = None


@pytest.fixture
def joystick(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[FakeJoystick]:
    """A joystick that is not plugged in yet; joy_node looks for it often."""
    monkeypatch.setattr("pyros1.robot_nodes.joy.node.RETRY_PERIOD", 0.02)
    fake = FakeJoystick(tmp_path / "js0")
    yield fake
    fake.unplug()


@pytest.fixture
def next_of() -> Callable[[Queue[Any], Callable[[Any], Any]], Any]:
    """Return a function that returns the next item of a queue for which a condition is true."""

    def wait(queue: Queue[Any], condition: Callable[[Any], Any]) -> Any:
        while True:
            item = queue.get(timeout=PATIENCE)
            if condition(item):
                return item

    return wait


@pytest.fixture
def wait_for_line(capfd: pytest.CaptureFixture[str]) -> Callable[[str], None]:
    """Return a function that waits until a text is on stderr."""

    def wait(text: str) -> None:
        end, seen = time.monotonic() + PATIENCE, ""
        while text not in seen:
            assert time.monotonic() < end, f"no {text!r} in {seen}"
            time.sleep(0.001)
            seen += capfd.readouterr().err

    return wait


@pytest.fixture
def until() -> Callable[[Callable[[], Any]], None]:
    """Return a function that waits until a condition is true of which nobody tells."""

    def wait(condition: Callable[[], Any]) -> None:
        end = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < end, "it never came true"
            time.sleep(0.002)

    return wait
