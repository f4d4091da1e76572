"""Subscribers of a player that come late, leave, are slow; and topics that the player publishes itself."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from pyros1.bag import BagWriter
from pyros1.bag.play.control import Control
from pyros1.bag.play.player import Player, PlayOptions
from pyros1.bag.play.read_ahead import BagSet
from pyros1.ground.timing import Time
from pyros1.msgs.rosgraph_msgs.msg import Clock, Log
from pyros1.msgs.std_msgs.msg import Header, String

from ...bodies import encode
from ...parts import publication_of

PATIENCE = 20.0
BEGIN = 1_700_000_000 * 10**9
MS = 10**6


def header_of(cls: Any, **more: str) -> dict[str, bytes]:
    fields = {"type": cls._type, "md5sum": cls._md5sum, "message_definition": cls._full_text, **more}
    return {name: value.encode() for name, value in fields.items()}


@pytest.fixture
def control() -> Iterator[Control]:
    """What the user of the player wants."""
    control = Control()
    yield control
    control.close()


@pytest.fixture
def node(make_node: Any) -> Any:
    """The player's node."""
    return make_node("play")


@pytest.fixture
def player(node: Any, control: Control) -> Iterator[Callable[..., Player]]:
    """Makes players of a bag, which is closed after the test."""
    opened: list[BagSet] = []

    def make(path: Path, **settings: Any) -> Player:
        opened.append(BagSet([str(path)]))
        return Player(node, opened[-1], PlayOptions(**settings), control)

    yield make
    for bags in opened:
        bags.close()


class Heard:
    """The messages of a topic."""

    def __init__(self, node: Any, topic: str, cls: Any, on_message: Callable[[], object] = lambda: None) -> None:
        self.messages: list[Any] = []
        self._on_message = on_message
        self._changed = threading.Condition()
        self.subscriber = node.subscribe(topic, cls, self._take)

    def _take(self, message: Any) -> None:
        self._on_message()
        with self._changed:
            self.messages.append(message)
            self._changed.notify_all()

    def wait(self, reached: Callable[[list[Any]], object]) -> list[Any]:
        with self._changed:
            assert self._changed.wait_for(lambda: reached(self.messages), PATIENCE), self.messages
            return list(self.messages)


def test_waits_until_every_topic_has_a_subscriber_at_a_time(
    make_node: Any, node: Any, player: Any, control: Control, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One that leaves before the others come does not count."""
    path = tmp_path / "x.bag"
    with BagWriter(path) as bag:
        for topic in ("/a", "/b"):
            bag.write(bag.add_connection(topic, header_of(String)), BEGIN, encode(String("x")))
    made = player(path)
    looked = threading.Semaphore(0)
    wait = control.wait
    monkeypatch.setattr(control, "wait", lambda seconds: (looked.release(), wait(seconds)))
    waiting = threading.Thread(target=made.wait_for_subscribers)
    waiting.start()
    ear = make_node("ear")
    try:
        leaving = Heard(ear, "/a", String).subscriber
        assert leaving.wait_for_publishers(timeout=PATIENCE)
        leaving.unregister()
        while publication_of(node, "/a").links:
            assert looked.acquire(timeout=PATIENCE)
        Heard(ear, "/b", String)
        for _ in range(5):
            assert looked.acquire(timeout=PATIENCE) and waiting.is_alive()
        Heard(ear, "/a", String)
        waiting.join(PATIENCE)
        assert not waiting.is_alive()
    finally:
        control.end()
        waiting.join(PATIENCE)


def test_a_slow_subscriber_loses_nothing_with_a_queue_without_limit(
    make_node: Any, player: Any, tmp_path: Path, transport: str
) -> None:
    """It stands still while all is played, more than sockets hold."""
    path, size, count = tmp_path / "x.bag", 1 << 20, 40
    with BagWriter(path) as bag:
        conn = bag.add_connection("/t", header_of(String))
        for number in range(count):
            bag.write(conn, BEGIN + number, encode(String(f"{number:{size}}")))
    played = threading.Event()
    made = player(path, immediate=True, queue_size=0)
    heard = Heard(make_node("ear"), "/t", String, on_message=lambda: played.wait(PATIENCE))
    made.wait_for_subscribers()
    assert made.run() == count
    played.set()
    assert [int(message.data) for message in heard.wait(lambda came: len(came) == count)] == list(range(count))
    assert made.dropped() == 0


def test_what_a_slow_subscriber_loses_is_counted(
    make_node: Any, player: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.subscribing.connector.find_local_context", lambda uri: None)  # real connections
    path, count = tmp_path / "x.bag", 100
    with BagWriter(path) as bag:
        conn = bag.add_connection("/t", header_of(String))
        for number in range(count):
            bag.write(conn, BEGIN + number, encode(String(f"{number:{1 << 20}}")))
    played = threading.Event()
    made = player(path, immediate=True, queue_size=5)
    heard = Heard(make_node("ear"), "/t", String, on_message=lambda: played.wait(PATIENCE))
    made.wait_for_subscribers()
    made.run()
    lost = made.dropped()
    assert lost > 0
    played.set()
    numbers = [int(message.data) for message in heard.wait(lambda came: came and int(came[-1].data) == count - 1)]
    assert len(numbers) == count - lost and numbers == sorted(numbers)


def test_topics_that_the_player_publishes_itself(make_node: Any, player: Any, tmp_path: Path) -> None:
    """A recording of everything has /rosout and /clock; their headers stay as they are, too."""
    path = tmp_path / "x.bag"
    with BagWriter(path) as bag:
        log = bag.add_connection("/rosout", header_of(Log, callerid="/talker", latching="1"))
        clock = bag.add_connection("/clock", header_of(Clock, callerid="/gazebo"))
        bag.write(log, BEGIN, encode(Log(header=Header(seq=77), name="/talker", msg="recorded")))
        bag.write(clock, BEGIN + MS, encode(Clock(Time(7, 8))))
    made = player(path)
    ear = make_node("ear")
    logs, clocks = Heard(ear, "/rosout", Log), Heard(ear, "/clock", Clock)
    made.wait_for_subscribers()
    assert not made.unplayable and made.run() == 2
    said = logs.wait(lambda came: any(one.name == "/talker" for one in came))
    assert [(one.header.seq, one.msg) for one in said if one.name == "/talker"] == [(77, "recorded")]
    assert [one.clock for one in clocks.wait(len)] == [Time(7, 8)]


def test_reading_that_began_ends_though_nothing_is_played(player: Any, control: Control, tmp_path: Path) -> None:
    """The user may end it while subscribers are waited for."""
    path = tmp_path / "x.bag"
    with BagWriter(path) as bag:
        conn = bag.add_connection("/t", header_of(String, latching="1"))
        for number in range(100):
            bag.write(conn, BEGIN + number * MS, encode(String(str(number))))
    made = player(path, start=0.05)
    made.read_ahead()
    control.end()
    assert made.run() == 0
