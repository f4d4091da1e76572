"""A viewer at the server's port."""

from __future__ import annotations

import json
import struct
import threading
from collections.abc import Callable
from contextlib import ExitStack
from time import time as now
from typing import Any

import pytest
from serving import PATIENCE, Served
from websockets.exceptions import ConnectionClosedError, InvalidStatus
from websockets.sync.client import connect

from pyros1.msgs import AnyMsg, from_definition
from pyros1.msgs.std_msgs.msg import Float64, String
from pyros1.node.topic_type import topic_type
from pyros1.web.foxglove import PROTOCOLS, frames

Make = Callable[..., Any]
Start = Callable[..., Served]


class Viewer:
    """A viewer, step by step."""

    def __init__(self, server: Served, token: str = "t", path: str = "/", **options: Any) -> None:
        options.setdefault("subprotocols", [PROTOCOLS[0]])
        self._link = f"ws://localhost:{server.port}{path}?token={token}"
        self._options = {"open_timeout": PATIENCE, "max_size": None, "compression": None, **options}
        self.channels: dict[str, dict[str, Any]] = {}
        self.services: dict[str, dict[str, Any]] = {}

    def __enter__(self) -> Viewer:
        self._end = ExitStack()
        self.socket = self._end.enter_context(connect(self._link, **self._options))
        return self

    def __exit__(self, *_: object) -> None:
        self._end.close()

    def send(self, op: str, **fields: Any) -> None:
        self.socket.send(json.dumps({"op": op, **fields}))

    def receive(self) -> dict[str, Any]:
        """Return the next frame; of a binary one its opcode and the rest."""
        frame = self.socket.recv(timeout=PATIENCE)
        if isinstance(frame, bytes):
            return {"op": frame[0], "data": frame[1:]}
        found: dict[str, Any] = json.loads(frame)
        if found["op"] == "advertise":
            self.channels.update({each["topic"]: each for each in found["channels"]})
        if found["op"] == "advertiseServices":
            self.services.update({each["name"]: each for each in found["services"]})
        return found

    def until(self, op: str | int, fits: Callable[[dict[str, Any]], Any] = lambda frame: True) -> dict[str, Any]:
        while True:
            frame = self.receive()
            if frame["op"] == op and fits(frame):
                return frame

    def channel(self, topic: str) -> dict[str, Any]:
        while topic not in self.channels:
            self.receive()
        return self.channels[topic]

    def subscribe(self, topic: str, number: int = 1) -> None:
        self.send("subscribe", subscriptions=[{"id": number, "channelId": self.channel(topic)["id"]}])

    def service(self, name: str) -> int:
        while name not in self.services:
            self.receive()
        number: int = self.services[name]["id"]
        return number

    def message(self, number: int = 1) -> bytes:
        """Return the payload of the next message of a subscription."""
        data = self.until(1, lambda frame: frame["data"][:4] == struct.pack("<I", number))["data"]
        return bytes(data[12:])


def test_messages_pass_through(serve: Start, make_node: Make) -> None:
    publisher = make_node("talker").advertise("a", Float64, latch=True)
    publisher.publish(2.5)
    with Viewer(serve(token="t")) as viewer:
        assert viewer.receive()["op"] == "serverInfo"
        viewer.subscribe("/a", 7)
        first = viewer.until(1)["data"]
        number, time = struct.unpack_from("<IQ", first)
        assert (number, first[12:]) == (7, struct.pack("<d", 2.5))
        assert abs(time / 1e9 - now()) < PATIENCE
        publisher.publish(3.5)
        assert viewer.message(7) == struct.pack("<d", 3.5)


def test_a_fault_where_a_message_arrives(serve: Start, make_node: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    """The topic's other viewers may not notice; this viewer's connection ends, since it would miss messages."""
    make_frame = frames.message

    def fail_for_one(subscription: int, time: int, payload: bytes) -> Any:
        if subscription == 7:
            raise ZeroDivisionError
        return make_frame(subscription, time, payload)

    monkeypatch.setattr(frames, "message", fail_for_one)
    publisher = make_node("talker").advertise("a", Float64)
    server = serve(token="t")
    with Viewer(server) as faulty, Viewer(server) as other:
        for viewer, number in ((faulty, 7), (other, 8)):
            viewer.subscribe("/a", number)
            viewer.send("getParameters", parameterNames=[], id="settled")
            viewer.until("parameterValues", lambda frame: frame.get("id") == "settled")
        publisher.publish(2.5)
        assert other.message(8) == struct.pack("<d", 2.5)
        with pytest.raises(ConnectionClosedError) as caught:
            faulty.until("never")
        assert caught.value.rcvd is not None and caught.value.rcvd.code == 1011
        publisher.publish(3.5)
        assert other.message(8) == struct.pack("<d", 3.5)


def test_nothing_is_subscribed_to_before_a_viewer_does(serve: Start, make_node: Make) -> None:
    publisher = make_node("talker").advertise("a", Float64)
    with Viewer(serve(token="t")) as viewer:
        viewer.channel("/a")
        assert publisher.num_connections == 0
        viewer.subscribe("/a")
        joined, left = threading.Event(), threading.Event()
        publisher.watch(lambda peer: joined.set(), lambda peer: left.set())
        assert joined.wait(PATIENCE)
        viewer.send("unsubscribe", subscriptionIds=[1])
        assert left.wait(PATIENCE)


def test_subscriptions_end_with_the_viewer(serve: Start, make_node: Make) -> None:
    publisher = make_node("talker").advertise("a", Float64)
    joined, left = threading.Event(), threading.Event()
    publisher.watch(lambda peer: joined.set(), lambda peer: left.set())
    with Viewer(serve(token="t")) as viewer:
        viewer.subscribe("/a")
        assert joined.wait(PATIENCE)
    assert left.wait(PATIENCE)


def test_topics_come_and_go(serve: Start, make_node: Make) -> None:
    node = make_node("talker")
    with Viewer(serve(token="t")) as viewer:
        publisher = node.advertise("a", Float64)
        number = viewer.channel("/a")["id"]
        publisher.unregister()
        viewer.until("unadvertise", lambda frame: number in frame["channelIds"])


def test_a_publisher_with_another_definition_gets_another_channel(serve: Start, make_node: Make) -> None:
    text = "float64 data\nfloat64 more\n"
    publisher = make_node("old").advertise(
        "a", AnyMsg, raw_type=topic_type(from_definition("std_msgs/Float64", text)), latch=True
    )
    publisher.publish(AnyMsg(struct.pack("<dd", 1.0, 2.0)))
    with Viewer(serve(token="t")) as viewer:
        wrong = viewer.channel("/a")
        viewer.subscribe("/a")
        viewer.until("unadvertise", lambda frame: wrong["id"] in frame["channelIds"])
        right = viewer.until("advertise")["channels"][0]
        assert right["schema"] == text
        viewer.subscribe("/a", 2)
        assert viewer.message(2) == struct.pack("<dd", 1.0, 2.0)


@pytest.mark.slow
def test_a_publisher_that_goes_from_one_definition_to_another_and_back(
    serve: Start, make_node: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.web.foxglove.connection.REPORT_PERIOD", 0.0)
    texts = ("float64 data\nfloat64 more\n", Float64._full_text) * 2
    make_node("ear").subscribe("a", AnyMsg, lambda message: None)  # the topic stays
    with Viewer(serve(token="t")) as viewer:
        for number, text in enumerate(texts):
            node = make_node("talker")
            raw_type = topic_type(from_definition("std_msgs/Float64", text))
            publisher = node.advertise("a", AnyMsg, raw_type=raw_type, latch=True)
            publisher.publish(AnyMsg(bytes(8 * text.count("float64"))))
            while viewer.channel("/a")["schema"] != text:
                viewer.subscribe("/a", 10 * number)
                viewer.until("advertise")
            viewer.subscribe("/a", 10 * number + 1)
            assert len(viewer.message(10 * number + 1)) == 8 * text.count("float64")
            node.shutdown()


def advertisement(kind: str = "std_msgs/String", encoding: str = "ros1") -> dict[str, Any]:
    return {"id": 4, "topic": "/said", "encoding": encoding, "schemaName": kind}


@pytest.mark.parametrize(("encoding", "payload"), [("ros1", b"\x05\0\0\0hello"), ("json", b'{"data": "hello"}')])
def test_publishing(serve: Start, make_node: Make, encoding: str, payload: bytes) -> None:
    heard: list[str] = []
    came, gone = threading.Event(), threading.Event()
    node = make_node("listener")

    def hear(message: Any) -> None:
        heard.append(message.data)
        came.set()

    node.subscribe("said", String, hear)
    with Viewer(serve(token="t")) as viewer:
        viewer.send("advertise", channels=[advertisement(encoding=encoding)])
        viewer.socket.send(b"\x01" + struct.pack("<I", 4) + payload)
        assert came.wait(PATIENCE)
        assert heard == ["hello"]
        viewer.socket.send(b"\x01" + struct.pack("<I", 4) + b"no such message")
        assert viewer.until("status")["id"] == "publish 4"
        viewer.send("unadvertise", channelIds=[4])
        viewer.send("subscribeConnectionGraph")
        told = viewer.until("connectionGraphUpdate")
        while not gone.is_set():
            published = {each["name"]: each["publisherIds"] for each in told["publishedTopics"]}
            if "/said" not in published or not published["/said"]:
                gone.set()
            else:
                told = viewer.until("connectionGraphUpdate")


def test_a_type_that_does_not_exist_is_told(serve: Start) -> None:
    with Viewer(serve(token="t")) as viewer:
        viewer.send("advertise", channels=[advertisement("my_msgs/None")])
        assert "my_msgs/None" in viewer.until("status")["message"]


def call(service: int, number: int, payload: bytes, encoding: bytes = b"ros1") -> bytes:
    return b"\x02" + struct.pack("<III", service, number, len(encoding)) + encoding + payload


def test_services(serve: Start, make_node: Make) -> None:
    def add(request: Any) -> int:
        if request.a < 0:
            raise ValueError("too small")
        return int(request.a + request.b)

    make_node("adder").advertise_service("add", "rospy_tutorials/AddTwoInts", add)
    with Viewer(serve(token="t")) as viewer:
        number = viewer.service("/add")
        viewer.socket.send(call(number, 5, struct.pack("<qq", 3, 4)))
        head = struct.pack("<III", number, 5, 4)
        assert viewer.until(3)["data"] == head + b"ros1" + struct.pack("<q", 7)
        viewer.socket.send(call(number, 6, b'{"a": 3, "b": 5}', b"json"))
        assert viewer.until(3)["data"].endswith(b'json{"sum":8}')
        for payload, reason in ((struct.pack("<qq", -1, 4), "too small"), (b"x", "")):
            viewer.socket.send(call(number, 7, payload))
            answer = viewer.until("serviceCallFailure")
            assert (answer["serviceId"], answer["callId"]) == (number, 7)
            assert reason in answer["message"]


def test_parameters(serve: Start, make_node: Make) -> None:
    server = serve(token="t")
    master = make_node("setter").master
    master.set_param("/speed", 2.0)
    with Viewer(server) as viewer:
        viewer.send("subscribeParameterUpdates", parameterNames=["/speed", "/name"])
        told = viewer.until("parameterValues")["parameters"]
        assert told == [{"name": "/speed", "value": 2.0, "type": "float64"}, {"name": "/name"}]
        master.set_param("/name", "arm")
        assert viewer.until("parameterValues")["parameters"] == [{"name": "/name", "value": "arm"}]
        wanted = [{"name": "/speed", "value": 3, "type": "float64"}, {"name": "/name"}, {"name": "/", "value": {}}]
        viewer.send("setParameters", parameters=wanted[:2], id="x")
        answer = viewer.until("parameterValues", lambda frame: frame.get("id") == "x")
        assert answer["parameters"] == [{"name": "/speed", "value": 3.0, "type": "float64"}, {"name": "/name"}]
        viewer.send("setParameters", parameters=wanted[2:])
        assert "would replace all" in viewer.until("status")["message"]
        assert master.get_param("/speed") == 3.0
        viewer.send("getParameters", parameterNames=[], id="y")
        every = viewer.until("parameterValues", lambda frame: frame.get("id") == "y")["parameters"]
        assert "/speed" in [each["name"] for each in every]


def test_files(serve: Start) -> None:
    with Viewer(serve(token="t")) as viewer:
        viewer.send("fetchAsset", uri="package://minimal_nodes/package.xml", requestId=8)
        data = viewer.until(4)["data"]
        assert data[:9] == struct.pack("<IBI", 8, 0, 0)
        assert b"<name>minimal_nodes</name>" in data
        viewer.send("fetchAsset", uri="package://minimal_nodes/../../__init__.py", requestId=9)
        data = viewer.until(4)["data"]
        assert data[:5] == struct.pack("<IB", 9, 1)
        assert data[9:].decode() == "this does not refer to a file in a package"


def test_nonsense_is_told_and_the_connection_goes_on(serve: Start) -> None:
    with Viewer(serve(token="t")) as viewer:
        for frame in ("", "[" * 1000, "{}", b"", b"\x07", b"\x01\x02", "x" * 2_000_000):
            viewer.socket.send(frame)
            assert viewer.until("status")["level"] == 2
        viewer.send("getParameters", parameterNames=["/none"], id="z")
        assert viewer.until("parameterValues")["id"] == "z"


def test_read_only(serve: Start, make_node: Make) -> None:
    make_node("adder").advertise_service("add", "std_srvs/Trigger", lambda request: (True, ""))
    with Viewer(serve(token="t", read_only=True)) as viewer:
        assert {"clientPublish", "services"}.isdisjoint(viewer.receive()["capabilities"])
        viewer.send("advertise", channels=[advertisement()])
        assert "read-only" in viewer.until("status")["message"]
        viewer.send("setParameters", parameters=[{"name": "/a", "value": 1}], id="x")
        assert viewer.until("parameterValues")["parameters"] == [{"name": "/a"}]


def test_only_some_topics(serve: Start, make_node: Make) -> None:
    node = make_node("talker")
    for name in ("/secret", "/camera/image"):
        node.advertise(name, Float64)
    server = serve(token="t", topics=("/camera/*",))
    node.master.set_param("/hidden", 1)
    with Viewer(server) as viewer:
        viewer.channel("/camera/image")
        assert [*viewer.channels] == ["/camera/image"]
        viewer.send("advertise", channels=[{**advertisement(), "topic": "/secret"}])
        assert "--topics" in viewer.until("status")["message"]
        viewer.send("setParameters", parameters=[{"name": "/hidden", "value": 2}], id="x")
        assert "--topics" in viewer.until("status")["message"]
        assert viewer.until("parameterValues")["parameters"] == [{"name": "/hidden"}]


def test_who_may_come_in(serve: Start) -> None:
    server = serve(token="t")
    foxglove = {"additional_headers": {"Origin": "https://app.foxglove.dev"}}
    with Viewer(server, **foxglove) as viewer:
        assert viewer.receive()["op"] == "serverInfo"
    with Viewer(server, path="/ws", subprotocols=[PROTOCOLS[1]]) as viewer:
        assert viewer.socket.subprotocol == PROTOCOLS[1]
    refused = [
        (401, Viewer(server, "wrong", **foxglove)),
        (403, Viewer(server, subprotocols=["pyros1.v1", PROTOCOLS[0]], **foxglove)),  # it could speak as our page
        (403, Viewer(serve(token=""), "", **foxglove)),  # without a token, any page could come in
    ]
    for status, each in refused:
        with pytest.raises(InvalidStatus, match=str(status)), each:
            pass


def test_simulated_time(serve: Start, make_node: Make) -> None:
    node = make_node("simulator")
    node.master.set_param("/use_sim_time", True)
    clock = node.advertise("/clock", "rosgraph_msgs/Clock", latch=True)
    server = serve(token="t")
    with Viewer(server) as viewer:
        assert "time" in viewer.receive()["capabilities"]
        message = clock.type()
        message.clock.secs, message.clock.nsecs = 12, 500
        clock.publish(message)
        told = viewer.until(2, lambda frame: frame["data"] != bytes(8))
        assert told["data"] == struct.pack("<Q", 12_000_000_500)
        node.advertise("a", Float64, latch=True).publish(1.0)
        viewer.subscribe("/a")
        assert struct.unpack_from("<IQ", viewer.until(1)["data"])[1] == 12_000_000_500


@pytest.mark.slow
def test_a_viewer_that_does_not_read_delays_nobody_and_then_sees_the_newest(serve: Start, make_node: Make) -> None:
    publisher = make_node("camera").advertise("a", String, queue_size=0, latch=True)
    publisher.publish("first")
    server = serve(token="t")
    body = "x" * 500_000
    with Viewer(server, max_queue=1) as slow, Viewer(server) as quick:
        for viewer in (slow, quick):
            viewer.subscribe("/a")
        for viewer in (slow, quick):
            assert viewer.message().endswith(b"first")
        for number in range(300):  # 150 MB
            publisher.publish(f"{number:03}{body}")
            if number % 10 == 9:
                wanted = f"{number:03}".encode()
                while viewer_number(quick.message()) != wanted:
                    pass
        seen = []
        while not seen or seen[-1] != b"299":
            seen.append(viewer_number(slow.message()))
        assert len(seen) < 200
        assert seen == sorted(seen)


def viewer_number(payload: bytes) -> bytes:
    return payload[4:7]


def test_an_answer_to_the_first_word_is_heard(serve: Start, make_node: Make) -> None:
    node = make_node("robot")
    echo = node.advertise("echo", String)
    node.subscribe("words", String, lambda message: echo.publish(message.data.upper()))
    server = serve(token="t")
    for _ in range(5):
        with Viewer(server) as viewer:
            channel = {"id": 1, "topic": "/words", "encoding": "json", "schemaName": "std_msgs/String"}
            viewer.subscribe("/echo")
            viewer.send("advertise", channels=[channel])
            viewer.socket.send(b"\x01" + struct.pack("<I", 1) + b'{"data": "word"}')
            assert viewer.message() == struct.pack("<I", 4) + b"WORD"
