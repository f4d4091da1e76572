"""One subscription per topic, shared by all views."""

from __future__ import annotations

import threading
import tracemalloc
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.ground.errors import MasterUnreachableError, MessageError, NodeError
from pyros1.msgs import AnyMsg, from_definition
from pyros1.msgs.geometry_msgs.msg import PointStamped
from pyros1.msgs.nav_msgs.msg import OccupancyGrid
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.observe.decoder import Decoder
from pyros1.web.hub import MAX_KEPT_BYTES, Arrival, Hub

from ..bodies import encode


def at_once(work: Callable[[], None]) -> None:
    """Subscribe in the same thread."""
    work()


class Subscriptions:
    """What a node would do, step by step."""

    def __init__(self) -> None:
        self.callbacks: dict[str, Callable[[AnyMsg], object]] = {}
        self.ended: list[str] = []
        self.links: list[Any] = []
        self.sizes: list[int] = []

    def subscribe(self, topic: str, callback: Callable[[AnyMsg], object]) -> Any:
        self.callbacks[topic] = callback
        ended = self.ended

        sizes = self.sizes

        class Subscriber:
            links = self.links
            queue_size = 1000

            def set_queue_size(self, size: int) -> None:
                self.queue_size = size
                sizes.append(size)

            def unregister(self) -> None:
                ended.append(topic)

        return Subscriber()

    def send(self, topic: str, number: float, latching: bool = False, caller: str = "/talker") -> None:
        raw = AnyMsg(encode(Float64(number)))
        word = "1" if latching else "0"
        if not any((link.header["callerid"], link.header["latching"]) == (caller, word) for link in self.links):
            self.connect(caller, latching)
        (raw._connection_header,) = (link.header for link in self.links if link.header["callerid"] == caller)
        self.callbacks[topic](raw)

    def connect(self, caller: str, latching: bool) -> None:
        """Make the connection of a publisher, in place of the one that it had."""
        self.links[:] = [link for link in self.links if link.header["callerid"] != caller]
        header = {
            "type": "std_msgs/Float64",
            "md5sum": Float64._md5sum,
            "message_definition": "float64 data",
            "callerid": caller,
            "latching": "1" if latching else "0",
        }
        self.links.append(SimpleNamespace(header=header))


@pytest.fixture
def subscriptions() -> Subscriptions:
    return Subscriptions()


@pytest.fixture
def hub(subscriptions: Subscriptions) -> Hub:
    return Hub(subscriptions.subscribe, lambda: 12.5, at_once)


def numbers(into: list[float]) -> Callable[[Arrival], object]:
    return lambda arrival: into.append(arrival.message.data)  # type: ignore[attr-defined]


def test_all_listeners_share_a_subscription(hub: Hub, subscriptions: Subscriptions) -> None:
    one: list[float] = []
    two: list[float] = []
    end_one = hub.listen("/a", numbers(one))
    first = subscriptions.callbacks["/a"]
    end_two = hub.listen("/a", numbers(two))
    assert subscriptions.callbacks["/a"] is first
    subscriptions.send("/a", 1.0)
    end_one()
    end_one()  # again does no harm
    subscriptions.send("/a", 2.0)
    assert (one, two, subscriptions.ended) == ([1.0], [1.0, 2.0], [])
    end_two()
    assert subscriptions.ended == ["/a"]
    hub.listen("/a", numbers(one))
    assert subscriptions.callbacks["/a"] is not first
    hub.close()
    assert subscriptions.ended == ["/a", "/a"]


def test_a_message_is_decoded_once_and_has_its_times(hub: Hub, subscriptions: Subscriptions) -> None:
    seen: list[Arrival] = []
    for _ in range(2):
        hub.listen("/a", seen.append)
    subscriptions.send("/a", 1.0)
    assert seen[0] is seen[1]
    assert seen[0].message is seen[1].message
    assert seen[0].time == 12.5


def test_a_later_listener_gets_what_is_latched_of_each_publisher(hub: Hub, subscriptions: Subscriptions) -> None:
    hub.listen("/a", lambda arrival: None)
    subscriptions.send("/a", 1.0, latching=True)
    subscriptions.send("/a", 2.0, latching=True)
    subscriptions.send("/a", 3.0, latching=True, caller="/other")
    subscriptions.send("/a", 4.0, caller="/third")
    later: list[float] = []
    hub.listen("/a", numbers(later))
    assert later == [2.0, 3.0]


def test_no_message_is_lost_that_comes_while_one_subscribes(subscriptions: Subscriptions) -> None:
    seen: list[float] = []

    def subscribe(topic: str, callback: Callable[[AnyMsg], object]) -> Any:
        found = subscriptions.subscribe(topic, callback)
        thread = threading.Thread(target=subscriptions.send, args=(topic, 7.0))
        thread.start()
        thread.join(10)
        return found

    Hub(subscribe, lambda: 0.0, at_once).listen("/a", numbers(seen))
    assert seen == [7.0]


def test_a_topic_that_cannot_be_subscribed_to_is_tried_anew() -> None:
    attempts: list[str] = []

    def subscribe(topic: str, callback: Callable[[AnyMsg], object]) -> Any:
        attempts.append(topic)
        raise NodeError("no")

    hub = Hub(subscribe, lambda: 0.0, at_once)
    for _ in range(2):
        hub.listen("/a", lambda arrival: None)
    assert attempts == ["/a", "/a"]


def test_nobody_waits_while_the_master_is_away() -> None:
    answer, unregistered, over = threading.Event(), threading.Event(), threading.Event()
    begun = threading.Event()

    def subscribe(topic: str, callback: Callable[[AnyMsg], object]) -> Any:
        begun.set()
        assert answer.wait(20)
        over.set()
        return SimpleNamespace(unregister=unregistered.set, links=[], queue_size=10)

    hub = Hub(subscribe, lambda: 0.0)
    end = hub.listen("/a", lambda arrival: None)
    other = hub.listen("/b", lambda arrival: None)
    end()
    other()
    hub.listen("/c", lambda arrival: None)
    assert begun.wait(20)
    hub.close()
    answer.set()
    assert over.wait(20)
    assert unregistered.wait(20)  # what nobody wants any more ends at once


def test_of_latched_messages_the_newest_is_the_last_and_those_of_the_dead_are_forgotten(
    hub: Hub, subscriptions: Subscriptions, monkeypatch: pytest.MonkeyPatch
) -> None:
    at = 100.0
    monkeypatch.setattr("pyros1.web.hub.monotonic", lambda: at)
    hub.listen("/a", lambda arrival: None)
    for number, caller in [(1.0, "/one"), (2.0, "/two"), (3.0, "/one")]:
        subscriptions.send("/a", number, latching=True, caller=caller)
    later: list[float] = []
    hub.listen("/a", numbers(later))
    assert later == [2.0, 3.0]
    subscriptions.links[:] = [link for link in subscriptions.links if link.header["callerid"] != "/one"]
    at += 5
    after: list[float] = []
    hub.listen("/a", numbers(after))
    assert after == [2.0]


def test_what_comes_while_one_gets_the_latched_message_comes_after_it(hub: Hub, subscriptions: Subscriptions) -> None:
    hub.listen("/a", lambda arrival: None)
    subscriptions.send("/a", 1.0, latching=True)
    later: list[float] = []
    sent: list[float] = []

    def sends(arrival: Arrival) -> None:
        if not sent:
            sent.append(2.0)
            subscriptions.send("/a", 2.0, latching=True)
        later.append(arrival.message.data)  # type: ignore[attr-defined]

    hub.listen("/a", sends)
    newest: list[float] = []
    hub.listen("/a", numbers(newest), lambda: subscriptions.send("/a", 3.0, latching=True))
    assert (later, newest) == ([1.0, 2.0, 3.0], [2.0, 3.0])
    subscriptions.send("/a", 4.0)
    assert (later[3:], newest[2:]) == ([4.0], [4.0])


def test_what_was_latched_is_forgotten_with_its_process(hub: Hub, subscriptions: Subscriptions) -> None:
    hub.listen("/a", lambda arrival: None)
    subscriptions.send("/a", 1.0, latching=True)
    subscriptions.send("/a", 2.0)  # started again under the same name, and latches no more
    later: list[float] = []
    hub.listen("/a", numbers(later))
    assert later == []
    subscriptions.send("/a", 3.0, latching=True)
    subscriptions.connect("/talker", latching=True)  # once more, and has nothing to say yet
    last: list[float] = []
    hub.listen("/a", numbers(last))
    assert (later, last) == ([3.0], [])


def test_a_latched_message_may_come_before_its_link_is_listed(hub: Hub, subscriptions: Subscriptions) -> None:
    hub.listen("/a", lambda arrival: None)
    subscriptions.send("/a", 1.0, latching=True)
    subscriptions.links.clear()
    later: list[float] = []
    hub.listen("/a", numbers(later))
    assert later == [1.0]


def test_who_wants_to_know_is_told_when_the_topic_is_subscribed_to(subscriptions: Subscriptions) -> None:
    jobs: list[Callable[[], None]] = []
    said: list[str] = []
    hub = Hub(
        subscriptions.subscribe,
        lambda: 0.0,
        jobs.append,
        wait_for_publishers=lambda topic, subscriber: said.append(f"settle {topic}"),
    )
    for name in ("first", "second"):
        hub.listen("/a", lambda arrival: None, lambda name=name: said.append(name))  # type: ignore[misc]
    assert said == []
    for job in jobs:
        job()
    assert said == ["settle /a", "first", "second"]
    hub.listen("/a", lambda arrival: None, lambda: said.append("third"))
    assert said[3:] == ["third"]


def test_who_wants_to_know_is_told_that_there_is_no_subscription() -> None:
    def subscribe(topic: str, callback: Callable[[AnyMsg], object]) -> Any:
        raise NodeError("no")

    said: list[str] = []
    Hub(subscribe, lambda: 0.0, at_once).listen("/a", lambda arrival: None, lambda: said.append("ready"))
    waits = Hub(subscribe, lambda: 0.0, lambda work: None)
    waits.listen("/a", lambda arrival: None, lambda: said.append("closed"))
    assert said == ["ready"]
    waits.close()
    assert said == ["ready", "closed"]


def test_a_subscription_whose_publishers_are_not_known_is_one_all_the_same(subscriptions: Subscriptions) -> None:
    def wait_for_publishers(topic: str, subscriber: Any) -> None:
        raise MasterUnreachableError("the master went just then")

    hub = Hub(subscriptions.subscribe, lambda: 0.0, at_once, wait_for_publishers)
    seen: list[float] = []
    ends = [hub.listen("/a", numbers(seen)) for _ in range(2)]
    subscriptions.send("/a", 1.0)
    assert seen == [1.0, 1.0]
    for end in ends:
        end()
    assert subscriptions.ended == ["/a"]


def test_large_messages_wait_in_smaller_numbers(hub: Hub, subscriptions: Subscriptions) -> None:
    hub.listen("/a", lambda arrival: None)
    subscriptions.send("/a", 1.0)
    assert subscriptions.sizes == []
    for size in (MAX_KEPT_BYTES // 8, MAX_KEPT_BYTES // 16, 2 * MAX_KEPT_BYTES):
        raw = AnyMsg(bytes(size))
        raw._connection_header = {"callerid": "/talker"}
        subscriptions.callbacks["/a"](raw)
    assert subscriptions.sizes == [8, 1]


def test_latched_messages_of_many_publishers_are_bounded(hub: Hub, subscriptions: Subscriptions) -> None:
    hub.listen("/a", lambda arrival: None)
    for number in range(6):
        raw = AnyMsg(bytes(MAX_KEPT_BYTES // 4))
        raw._connection_header = {"callerid": f"/talker{number}", "latching": "1"}
        subscriptions.links.append(SimpleNamespace(header=raw._connection_header))
        subscriptions.callbacks["/a"](raw)
    later: list[Arrival] = []
    hub.listen("/a", later.append)
    assert [each.raw._connection_header["callerid"] for each in later] == [f"/talker{n}" for n in range(2, 6)]  # type: ignore[index]


@pytest.mark.parametrize(
    ("old", "new", "fits"),
    [
        ("Point point", "Point point", True),
        ("Point point", "Point point\nint8 more", True),
        ("Point point", "Point[] point", False),  # with the same checksum
        ("float64 z", "string z", False),
        ("string frame_id", "string frame", False),
    ],
)
def test_fields_that_are_relied_on_are_there(old: str, new: str, fits: bool) -> None:
    cls = from_definition("geometry_msgs/PointStamped", PointStamped._full_text.replace(old, new))
    raw = AnyMsg(encode(cls()))
    raw._connection_header = {"type": cls._type, "md5sum": cls._md5sum, "message_definition": cls._full_text}
    arrival = Arrival(raw, 0.0, 0.0, Decoder())
    assert type(arrival.message) is type(cls()) or arrival.message._full_text == cls._full_text
    if fits:
        assert arrival.checked_message is arrival.message
    else:
        with pytest.raises(MessageError, match=r"a different definition of \w+/\w+ than this machine"):
            _ = arrival.checked_message


@pytest.mark.parametrize("text", ["", "Header header\nPoint point", "%", "Header hea"])
def test_messages_of_other_client_libraries(text: str) -> None:
    """Their definitions are odd, and bytes are behind their messages."""
    header = {"type": PointStamped._type, "md5sum": PointStamped._md5sum, "message_definition": text}
    point = PointStamped()
    point.point.x = 2.5
    arrival = Arrival(AnyMsg(encode(point) + b"\x55", header), 0.0, 0.0, Decoder())
    for message in (arrival.message, arrival.checked_message, arrival.arrays):
        assert message.point.x == 2.5  # type: ignore[attr-defined]  # made from a definition


def test_arrays_of_large_messages_take_no_more_than_their_bytes() -> None:
    grid = OccupancyGrid(data=[7] * 1_000_000)
    raw = AnyMsg(encode(grid))
    raw._connection_header = {"type": grid._type, "md5sum": grid._md5sum, "message_definition": grid._full_text}
    arrival = Arrival(raw, 0.0, 0.0, Decoder())
    tracemalloc.start()
    message: Any = arrival.arrays
    assert tracemalloc.get_traced_memory()[0] < 1_000_000  # a list takes 8
    tracemalloc.stop()
    assert arrival.arrays is message and message.data.sum() == 7_000_000
