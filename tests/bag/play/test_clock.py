"""When messages and /clock are played, to the nanosecond: time is made by the player's own waiting.

Feature: `/clock` of a bag -- exact with rate, start, pause, step, loop, gaps
"""

from __future__ import annotations

import itertools
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from pyros1.bag import BagWriter
from pyros1.bag.play.control import Control
from pyros1.bag.play.player import Player, PlayOptions
from pyros1.bag.play.read_ahead import BagSet
from pyros1.msgs import AnyMsg
from pyros1.msgs.std_msgs.msg import Float64

BEGIN = 1_700_000_000 * 10**9
MS = 10**6
START = 1000.0


class Publisher:
    """Notes what is published."""

    num_connections = 1
    dropped = 0

    def __init__(self, stage: Stage, name: str) -> None:
        self.name = name
        self._stage = stage

    def publish(self, message: Any) -> None:
        value = struct.unpack("<d", message._buff)[0] if isinstance(message, AnyMsg) else message.clock.to_nsec()
        self._stage.came.append((self._stage.now - START, self.name, value))


class Stage:
    """The player's node, clock, and user.

    Attributes:
        now: wall time in seconds.
        late: seconds by which every wait is too long.
        came: wall time since the beginning, topic, and value of what was published; of /clock nanoseconds.
        plan: what the user does, and when.
    """

    def __init__(self) -> None:
        self.now = START
        self.late = 0.0
        self.came: list[tuple[float, str, Any]] = []
        self.plan: list[tuple[float, Callable[[], object]]] = []

    def advertise(self, topic: str, *_: object, **__: object) -> Publisher:
        return Publisher(self, topic)

    def wait(self, seconds: float) -> None:
        until = self.now + seconds + self.late if seconds > 0 else self.now
        if self.plan and START + self.plan[0][0] <= until:
            moment, action = self.plan.pop(0)
            self.now = max(self.now, START + moment)
            action()
        else:
            self.now = until

    def clocks(self) -> list[tuple[float, float]]:
        """Wall time in seconds, and bag time in ms since its beginning, of each /clock."""
        return [(wall, (value - BEGIN) / MS) for wall, topic, value in self.came if topic == "clock"]

    def numbers(self) -> list[tuple[float, float]]:
        """Wall time in seconds, and value of each message on /t."""
        return [(wall, value) for wall, topic, value in self.came if topic == "/t"]


@pytest.fixture
def control() -> Iterator[Control]:
    made = Control()
    yield made
    made.close()


@pytest.fixture
def stage(monkeypatch: pytest.MonkeyPatch, control: Control) -> Stage:
    made = Stage()
    monkeypatch.setattr("pyros1.bag.play.player.perf_counter", lambda: made.now)
    monkeypatch.setattr(control, "wait", made.wait)
    return made


@pytest.fixture
def play(tmp_path: Path, stage: Stage, control: Control) -> Callable[..., int]:
    """Plays a bag with a message on /t at each time, in ms, which is its value."""

    def run(times: Any, **settings: Any) -> int:
        path = tmp_path / "x.bag"
        with BagWriter(path) as bag:
            header = {"type": Float64._type, "md5sum": Float64._md5sum, "message_definition": Float64._full_text}
            conn = bag.add_connection("/t", {name: text.encode() for name, text in header.items()})
            for time in times:
                bag.write(conn, BEGIN + int(time * MS), struct.pack("<d", time))
        node: Any = stage
        with BagSet([str(path)]) as bags:
            return Player(node, bags, PlayOptions(**settings), control).run()

    return run


def close_to(pairs: Any) -> list[Any]:
    return [(pytest.approx(wall, abs=1e-9), pytest.approx(value, abs=1e-3)) for wall, value in pairs]


@pytest.mark.parametrize("rate", [0.25, 1.0, 8.0])
def test_messages_and_clock_at_a_rate(stage: Stage, play: Any, rate: float) -> None:
    assert play(range(0, 1000, 7), clock_rate=100, rate=rate) == 143
    assert stage.numbers() == close_to((time / 1000 / rate, time) for time in range(0, 1000, 7))
    ticks = int(0.994 / rate * 100) + 1
    assert stage.clocks() == close_to((tick * 0.01, tick * 10 * rate) for tick in range(ticks))


def test_late_waking_does_not_add_up(stage: Stage, play: Any) -> None:
    """What is late stays late by one wait's error, and the clock says the time that it is."""
    stage.late = 0.0004
    play(range(0, 1000, 7), clock_rate=100)
    for wall, value in stage.numbers():
        assert -1e-9 <= wall - value / 1000 <= stage.late + 1e-9
    for number, (wall, value) in enumerate(stage.clocks()):
        assert -1e-9 <= wall - number * 0.01 <= stage.late + 1e-9
        assert value == pytest.approx(min(wall * 1000, value if value % 7 == 0 else wall * 1000), abs=1e-3)


def test_part_of_a_bag(stage: Stage, play: Any) -> None:
    """The clock begins with the first message that is played, and never passes the last."""
    play(range(0, 1000, 30), clock_rate=100, start=0.1, duration=0.2)
    assert stage.numbers() == close_to(((time - 120) / 1000, time) for time in range(120, 301, 30))
    assert stage.clocks() == close_to((tick * 0.01, 120 + tick * 10) for tick in range(19))


def test_pause_holds_the_clock_which_ticks_on(stage: Stage, play: Any, control: Control) -> None:
    stage.plan = [(0.2045, control.toggle), (1.2045, control.toggle)]
    play(range(0, 401, 10), clock_rate=100)
    assert stage.numbers() == close_to((t / 1000 if t <= 200 else t / 1000 + 1.0, t) for t in range(0, 401, 10))
    before, is_paused, after = (
        [(wall, value) for wall, value in stage.clocks() if low <= wall < high]
        for low, high in ((0, 0.2045), (0.2045, 1.2045), (1.2045, 9))
    )
    assert before == close_to((tick * 0.01, tick * 10) for tick in range(21))
    assert is_paused == close_to(((21 + tick) * 0.01, 204.5) for tick in range(100))
    assert after == close_to(((121 + tick) * 0.01, 210 + tick * 10) for tick in range(20))


def test_steps_take_the_clock_to_their_messages(stage: Stage, play: Any, control: Control) -> None:
    control.is_paused = True
    stage.plan = [(0.105, control.step), (0.205, control.step), (0.305, control.toggle)]
    play([0, 50, 80, 100], clock_rate=10)
    assert stage.numbers() == close_to([(0.105, 0), (0.205, 50), (0.335, 80), (0.355, 100)])
    assert [value for _, value in stage.clocks()] == [0, 0, 0, 0, 50, 50]
    assert [topic for _, topic, _ in stage.came[2:4]] == ["clock", "/t"], "the clock is there before the message"


def test_every_loop_begins_anew_and_never_goes_back_within(stage: Stage, play: Any, control: Control) -> None:
    stage.plan = [(1.05, control.end)]
    play(range(0, 301, 10), clock_rate=100, loop=True, start=0.1)
    numbers = stage.numbers()
    assert [value for _, value in numbers[:63]] == [*range(100, 301, 10)] * 3
    values = [value for _, value in stage.clocks()]
    passes = [0, *(index for index, (a, b) in enumerate(itertools.pairwise(values), 1) if b < a)]
    assert len(passes) == 6 and all(values[index] == 100 for index in passes)
    assert {round(b - a) for a, b in itertools.pairwise(values) if b >= a} <= {0, 10}


def test_gaps_that_are_skipped(stage: Stage, play: Any) -> None:
    play([0, 20, 100_000, 100_020], clock_rate=100, skip_empty=5.0)
    assert stage.numbers() == close_to([(0, 0), (0.02, 20), (0.02, 100_000), (0.04, 100_020)])
    ticks = [(0, 0), (0.01, 10), (0.02, 20), (0.02, 100_000), (0.03, 100_010), (0.04, 100_020)]
    assert stage.clocks() == close_to(ticks), "the clock jumps before the message comes"


def test_without_waiting_each_message_brings_its_time(stage: Stage, play: Any) -> None:
    play([0, 20, 100_000], clock_rate=1, immediate=True)
    assert [(topic, value) for _, topic, value in stage.came] == [
        item for time in (0, 20, 100_000) for item in (("clock", BEGIN + time * MS), ("/t", time))
    ]
