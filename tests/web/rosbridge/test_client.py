"""A client says anything: nothing breaks, and each frame that cannot be done gives an error."""

from __future__ import annotations

import json
import queue
import threading
from collections.abc import Callable
from contextlib import ExitStack
from time import monotonic
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pyros1.msgs import AnyMsg, Message
from pyros1.msgs.sensor_msgs.msg import Image, Imu, LaserScan
from pyros1.msgs.std_msgs.msg import MultiArrayDimension, MultiArrayLayout, String
from pyros1.observe.decoder import Decoder
from pyros1.web.hub import Arrival
from pyros1.web.robot import Robot
from pyros1.web.rosbridge.client import MAX_CALLS, Client
from pyros1.web.rosbridge.outbox import MAX_FRAME_BYTES
from pyros1.web.service_calls import MAX_CONCURRENT_CALLS
from pyros1.wire.handshake import TopicType

from ...bodies import encode

_VALUES = st.recursive(
    st.sampled_from([None, True, 0, -1, 1.5, float("nan"), 1 << 70, "", "x", "\ud800", "now", "AAAA", "\0"]),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(["data", "header", "stamp", "secs", "nsecs", "x", "orientation"]), inner, max_size=3
        )
    ),
    max_leaves=8,
)
_TOPICS = st.sampled_from(["/imu", "imu", "~imu", "/a//b", "/a b", "/\x00", "/ä", "", "/other", "/" + "x" * 2000, 5])
_TYPES = st.sampled_from(
    [
        "sensor_msgs/Imu",
        "std_srvs/SetBool",
        "std_msgs/String",
        "a/B",
        "",
        "/",
        "../x",
        "std_msgs",
        "\x00/\x00",
        "a" * 5000,
    ]
)
_SERVICES = st.sampled_from(
    ["/rosapi/get_param", "/rosapi/set_param", "/rosapi/message_details", "/rosapi/topic_type", "/imu", "/x", "a b", 1]
)
_TEXTS = st.sampled_from(
    ["/imu", "1", "{", "\ud800", "\x00", "std_msgs/String", "a" * 5000, "/", "~", "", "null", "[[]]"]
)
_FRAMES = st.fixed_dictionaries(
    {
        "op": st.sampled_from(
            [
                "advertise",
                "unadvertise",
                "publish",
                "subscribe",
                "unsubscribe",
                "call_service",
                "advertise_service",
                "unadvertise_service",
                "service_response",
            ]
        )
    },
    optional={
        "id": st.sampled_from(["a", 1, None, [], "\ud800"]),
        "topic": _TOPICS,
        "type": _TYPES,
        "service": _SERVICES,
        "msg": _VALUES,
        "args": _VALUES | st.fixed_dictionaries({"name": _TEXTS, "value": _TEXTS, "type": _TEXTS, "topic": _TEXTS}),
        "values": _VALUES,
        "result": st.booleans(),
        "compression": st.sampled_from(["none", "png", "cbor", "cbor-raw"]),
        "fragment_size": st.sampled_from([0, 1, 50]),
        "throttle_rate": st.sampled_from([0, 1, 1e9]),
        "queue_length": st.sampled_from([0, 1, 10**9]),
        "latch": st.booleans(),
    },
)


@pytest.mark.slow
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(_FRAMES, min_size=1, max_size=8))
def test_any_operations(robot: Robot, frames: list[dict[str, Any]]) -> None:
    def now(function: Callable[[], object]) -> None:
        function()

    client = Client(robot, now, lambda: None)
    try:
        done = client.handle(map(json.dumps, frames))
        while not done:
            client.pending_subscriptions.abandon()
            done = client.handle(())
        told = client.take(monotonic()).frames
        assert all(isinstance(frame, (str, bytes)) for frame in told)
    finally:
        client.close()


def test_messages_that_cannot_be_decoded_are_told_once(robot: Robot, make_node: Callable[..., Any]) -> None:
    raw_type = TopicType("sensor_msgs/Imu", Imu._md5sum, Imu._full_text)
    publisher = make_node("liar").advertise("imu", AnyMsg, raw_type=raw_type, latch=True)
    publisher.publish(AnyMsg(b"too short"))
    arrived: list[Any] = []
    client = Client(robot, lambda function: None, lambda: arrived.append(None))
    try:
        told: list[Any] = []
        for number in range(3):
            client.handle([json.dumps({"op": "subscribe", "topic": "/imu", "id": number})])
            until = monotonic() + 20
            while not arrived and monotonic() < until:
                pass
            arrived.clear()
            told += client.take(monotonic())[0]
        assert [json.loads(frame)["op"] for frame in told] == ["status"]
    finally:
        client.close()


def test_many_messages_or_fragments_are_not_encoded_quickly(robot: Robot, make_node: Callable[..., Any]) -> None:
    publisher = make_node("talker").advertise("topic", String)
    wakes: queue.Queue[None] = queue.Queue()
    client = Client(robot, lambda function: None, lambda: wakes.put(None))
    try:
        for fragment_size, count, is_quick in ((None, 1, False), (None, 32, True), (None, 33, False), (16, 1, False)):
            request = {"op": "subscribe", "topic": "/topic", "type": "std_msgs/String", "fragment_size": fragment_size}
            done = client.handle([json.dumps(request)])
            until = monotonic() + 20
            while (not done or client.pending_subscriptions) and monotonic() < until:
                done = client.handle(())
            for _ in range(count):
                publisher.publish("x")
                wakes.get(timeout=20)
            due = client.take(monotonic())
            assert len(list(due.frames)) >= count
            assert due.is_quick == is_quick
    finally:
        client.close()


@pytest.mark.parametrize(
    ("kind", "size", "compression", "is_quick"),
    [
        (String, 10, "none", True),
        (String, 10, "png", False),
        (String, 20_000, "none", False),
        (String, 20_000, "cbor", True),
        (String, 2_000_000, "cbor", False),
        (String, 20_000, "cbor-raw", True),
        (String, 2_000_000, "cbor-raw", False),
        (MultiArrayLayout, 10, "cbor", True),
        (MultiArrayLayout, 2_000, "cbor", False),
    ],
)
def test_which_messages_are_encoded_quickly(
    robot: Robot, make_node: Callable[..., Any], kind: Any, size: int, compression: str, is_quick: bool
) -> None:
    """But the first one of a type never is: its class must be created."""
    publisher = make_node("talker").advertise("topic", kind, latch=True)
    publisher.publish(String("x" * size) if kind is String else MultiArrayLayout(dim=[MultiArrayDimension()] * size))
    with ExitStack() as stack:
        for expected in (is_quick and compression == "cbor-raw", is_quick):
            came = threading.Event()
            client = Client(robot, lambda function: None, came.set)
            stack.callback(client.close)
            client.handle([json.dumps({"op": "subscribe", "topic": "/topic", "compression": compression})])
            frames: list[Any] = []
            while not frames:
                assert came.wait(20)
                came.clear()
                due = client.take(monotonic())
                frames = list(due.frames)
            assert due.is_quick == expected


@pytest.mark.parametrize("text", ["", "Header header", "%"])
def test_messages_of_other_client_libraries(robot: Robot, make_node: Callable[..., Any], text: str) -> None:
    """Their definitions are odd, and bytes are behind their messages."""
    publisher = make_node("board").advertise(
        "imu", AnyMsg, raw_type=TopicType("sensor_msgs/Imu", Imu._md5sum, text), latch=True
    )
    imu = Imu()
    imu.orientation.w = 0.5
    publisher.publish(AnyMsg(encode(imu) + b"\x55"))
    came = threading.Event()
    client = Client(robot, lambda function: None, came.set)
    try:
        client.handle([json.dumps({"op": "subscribe", "topic": "/imu"})])
        found: list[Any] = []
        while not found:
            assert came.wait(20)
            came.clear()
            found += map(json.loads, client.take(monotonic())[0])
        assert found[0]["msg"]["orientation"]["w"] == 0.5
    finally:
        client.close()


def test_calls_without_end_are_refused(robot: Robot) -> None:
    begun: list[Callable[[], object]] = []
    client = Client(robot, begun.append, lambda: None)
    try:
        calls = [{"op": "call_service", "service": "/rosapi/get_time", "id": n} for n in range(MAX_CALLS + 5)]
        client.handle(map(json.dumps, calls))
        assert len(begun) == MAX_CONCURRENT_CALLS
        told = [json.loads(frame) for frame in client.take(monotonic())[0]]
        assert [each["result"] for each in told] == [False] * 5
        for run in begun:  # which grows: one that ends makes room for the next
            run()
        assert len(begun) == MAX_CALLS
        answers = [json.loads(frame) for frame in client.take(monotonic())[0]]
        assert all(each["result"] for each in answers)
        assert [each["id"] for each in answers] == list(range(MAX_CALLS))  # in their order
    finally:
        client.close()


def test_what_comes_behind_a_subscription_waits_until_it_is_made(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    ready: list[Callable[[], object]] = []
    monkeypatch.setattr(robot, "listen", lambda topic, listener, done: ready.append(done) or (lambda: None))
    go_on: list[None] = []
    client = Client(robot, lambda function: None, lambda: None, lambda: go_on.append(None))
    try:
        subscriptions = [{"op": "subscribe", "topic": topic} for topic in ("/a", "/b")]
        wrong = {"op": "unsubscribe", "topic": "/c", "id": "x"}
        assert not client.handle(map(json.dumps, [{"op": "set_level", "level": "info"}, *subscriptions, wrong, wrong]))
        assert len(ready) == 2 and not list(client.take(monotonic())[0])
        ready[0]()
        assert not client.handle(()) and not go_on
        ready[1]()
        assert go_on and client.handle(())
        assert len(list(client.take(monotonic())[0])) == 2
    finally:
        client.close()


def test_calls_wait_while_the_client_does_not_read_its_answers(robot: Robot) -> None:
    begun: list[Callable[[], object]] = []
    client = Client(robot, begun.append, lambda: None)
    try:
        client.outbox.enqueue("x" * (MAX_FRAME_BYTES + 1))
        client.handle([json.dumps({"op": "call_service", "service": "/rosapi/get_time", "id": 1})])
        assert not begun
        client.take(monotonic())
        assert len(begun) == 1
    finally:
        client.close()


class Sender:
    """Sends frames from the threads in which messages arrive, if it can."""

    def __init__(self) -> None:
        self.sent: list[Any] = []
        self.can_send = True
        self.before = lambda: None

    def __call__(self, frames: Any) -> bool:
        self.before()
        if self.can_send:
            self.sent += frames
        return self.can_send


class Bench:
    """A client of a topic whose messages a test brings."""

    def __init__(self, robot: Robot, monkeypatch: pytest.MonkeyPatch, cls: type[Message], **request: Any) -> None:
        self.send = Sender()
        self.faults: list[Exception] = []
        self.wakes: list[None] = []
        listeners: list[Callable[[Arrival], object]] = []
        monkeypatch.setattr(
            robot, "listen", lambda topic, listener, done: listeners.append(listener) or done() or (lambda: None)
        )
        self.client = Client(
            robot,
            lambda function: None,
            lambda: self.wakes.append(None),
            send_now=self.send,
            on_fault=self.faults.append,
        )
        self.client.handle([json.dumps({"op": "subscribe", "topic": "/topic", **request})])
        self.client.outbox.release()
        self._listener = listeners[0]
        self._header = {"type": cls._type, "md5sum": cls._md5sum, "message_definition": cls._full_text}
        self._decoder = Decoder()
        assert self.arrival(cls()).message_class  # made before, as by the first message

    def arrival(self, message: Message | bytes) -> Arrival:
        raw = AnyMsg(message if isinstance(message, bytes) else encode(message))
        raw._connection_header = self._header
        return Arrival(raw, 1.5, monotonic(), self._decoder)

    def bring(self, message: Message | bytes) -> list[Any]:
        """Bring a message; return the frames that were sent from this thread."""
        self.send.sent.clear()
        self._listener(self.arrival(message))
        return self.send.sent[:]

    def taken(self) -> list[Any]:
        """What the loop takes and sends."""
        frames = list(self.client.take(monotonic()).frames)
        self.client.outbox.release()
        return frames


def test_messages_are_sent_from_the_threads_in_which_they_arrive(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench(robot, monkeypatch, String)
    frame = '{"op":"publish","topic":"/topic","msg":{"data":"a"}}'
    assert bench.bring(String("a")) == bench.bring(String("a")) == [frame]
    assert not bench.wakes and not bench.taken()
    bench.send.can_send = False
    assert not bench.bring(String("a")) and bench.wakes
    bench.send.can_send = True
    assert not bench.bring(String("b"))  # it may not overtake the first
    assert bench.taken() == [frame, frame.replace('"a"', '"b"')]
    assert bench.bring(String("a")) == [frame]


@pytest.mark.parametrize(
    ("message", "request_", "is_sent"),
    [
        (String("x" * 15_000), {}, True),
        (String("x" * 20_000), {}, True),
        (String("x" * 2_000_000), {}, False),
        (Image(data=bytes(1_000_000)), {}, True),
        (Image(data=bytes(2_000_000)), {}, False),
        (Image(data=bytes(2_000_000)), {"compression": "cbor"}, True),
        (Image(data=bytes(2_000_000)), {"compression": "cbor-raw"}, True),
        (LaserScan(ranges=[1.0] * 3_000), {}, True),
        (LaserScan(ranges=[1.0] * 5_000), {}, False),
        (LaserScan(ranges=[1.0] * 5_000), {"compression": "cbor"}, True),
        (MultiArrayLayout(dim=[MultiArrayDimension(label="x" * 20_000)]), {"compression": "cbor"}, False),
        (MultiArrayLayout(dim=[MultiArrayDimension(label="x")]), {"compression": "cbor"}, True),
        (MultiArrayLayout(dim=[MultiArrayDimension(label="x" * 20_000)]), {}, False),
        (String("x"), {"compression": "png"}, False),
        (String("x"), {"fragment_size": 1_000}, False),
        (String("x"), {"throttle_rate": 1}, False),
        (String("x"), {"queue_length": 1}, True),
    ],
    ids=lambda each: "" if isinstance(each, Message) else None,
)
def test_which_messages_are_sent_where_they_arrive(
    robot: Robot, monkeypatch: pytest.MonkeyPatch, message: Message, request_: dict[str, Any], is_sent: bool
) -> None:
    bench = Bench(robot, monkeypatch, type(message), **request_)
    assert bool(bench.bring(message)) is is_sent
    assert bool(bench.taken()) is not is_sent


def test_a_class_that_must_be_made_first(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    """It can take a second, in which no other client would get the topic's messages."""
    bench = Bench(robot, monkeypatch, String)
    monkeypatch.setattr(Arrival, "has_class", False)
    assert not bench.bring(String("a"))
    assert bench.taken()


def test_a_message_that_cannot_be_decoded_where_it_arrives(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench(robot, monkeypatch, String)
    assert not bench.bring(b"x") and not bench.bring(b"x")
    (status,) = bench.taken()
    assert json.loads(status)["op"] == "status"
    assert bench.bring(String("a"))


def test_a_fault_where_a_message_arrives(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    """The topic's other clients may not notice; this client's connection ends."""

    def fail() -> None:
        raise ZeroDivisionError

    bench = Bench(robot, monkeypatch, String)
    bench.send.before = fail
    assert not bench.bring(String("a"))
    assert [type(each) for each in bench.faults] == [ZeroDivisionError]
    bench.send.before = lambda: None
    assert bench.bring(String("b"))
