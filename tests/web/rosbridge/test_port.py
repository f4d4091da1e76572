"""Clients on the server's port."""

from __future__ import annotations

import base64
import json
import queue
import threading
from collections.abc import Callable
from contextlib import ExitStack
from random import Random
from time import sleep
from typing import Any

import cbor2
import pytest
from serving import PATIENCE, Served
from websockets.exceptions import InvalidStatus
from websockets.sync.client import ClientConnection, connect

from pyros1.graph import Graph
from pyros1.ground.errors import ServiceError
from pyros1.msgs.rospy_tutorials.srv import AddTwoInts
from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.msgs.std_msgs.msg import Float64, String
from pyros1.msgs.std_srvs.srv import SetBool, SetBoolRequest
from pyros1.node import Node
from pyros1.web.robot import Robot
from pyros1.web.server.access import Access
from pyros1.web.server.server import PROTOCOL
from pyros1.web.server.shared_transport import SharedTransport

Serve = Callable[..., Served]
MakeNode = Callable[..., Any]


def client(server: Served, query: str = "", path: str = "/", **options: Any) -> ClientConnection:
    return connect(f"ws://localhost:{server.port}{path}{query}", open_timeout=PATIENCE, max_size=None, **options)


def enqueue(socket_: ClientConnection, op: str, **fields: Any) -> None:
    socket_.send(json.dumps({"op": op, **fields}))


def hear(socket_: ClientConnection) -> Any:
    frame = socket_.recv(timeout=PATIENCE)
    return json.loads(frame) if isinstance(frame, str) else cbor2.loads(frame)


def ask(socket_: ClientConnection, service: str, args: Any = None, **fields: Any) -> Any:
    """Call a service and return what comes next, which is the answer."""
    enqueue(socket_, "call_service", service=service, args=args, id="call", **fields)
    return hear(socket_)


def settle(socket_: ClientConnection) -> None:
    """Wait until what the client said before has been done."""
    enqueue(socket_, "unadvertise_service", service="none", id="settle")
    assert hear(socket_)["id"] == "settle"


def test_who_may_come_in(serve: Serve) -> None:
    server = serve(token="t", origins=("http://ui.example",))
    for query, origin, status in (
        ("", None, "401"),
        ("?token=x", None, "401"),
        ("?token=x", "http://other.example", "401"),
        ("", "http://ui.example", "401"),
    ):
        with pytest.raises(InvalidStatus, match=status):
            client(server, query, origin=origin)
    for path in ("/", "/rosbridge"):
        for origin in (None, "http://ui.example", "http://other.example", "null", f"http://localhost:{server.port}"):
            with client(server, "?token=t", path, origin=origin) as socket_:
                assert ask(socket_, "/rosapi/get_time")["result"]
    with pytest.raises(InvalidStatus, match="403"):  # it could speak as our page
        client(server, "?token=t", "/", origin="http://other.example", subprotocols=[PROTOCOL])
    with client(serve(token=""), subprotocols=["rosbridge_v2"]) as socket_:  # type: ignore[list-item]
        assert ask(socket_, "/rosapi/get_time")["result"]
    open_to_one = serve(token="", origins=("http://ui.example",))
    with pytest.raises(InvalidStatus, match="403"):
        client(open_to_one, origin="http://other.example")
    with client(open_to_one, origin="http://ui.example") as socket_:
        assert ask(socket_, "/rosapi/get_time")["result"]


def test_publish(serve: Serve, make_node: MakeNode) -> None:
    got: queue.Queue[Any] = queue.Queue()
    node = make_node("listener")
    node.subscribe("words", String, got.put)
    node.subscribe("image", Image, got.put)
    with client(serve(token="")) as socket_:
        enqueue(socket_, "advertise", topic="words", type="std_msgs/String")
        enqueue(socket_, "publish", topic="words", msg={"data": "one"})
        assert got.get(timeout=PATIENCE).data == "one"
        data = base64.b64encode(b"abc").decode()
        enqueue(socket_, "advertise", topic="/image", type="sensor_msgs/Image", latch=True, queue_size=1)
        enqueue(socket_, "publish", topic="/image", msg={"data": data, "height": 1, "header": {"frame_id": "eye"}})
        image = got.get(timeout=PATIENCE)
        assert (image.data, image.height, image.header.frame_id) == (b"abc", 1, "eye")
        assert image.header.stamp.secs > 0
        enqueue(socket_, "publish", topic="/words", msg={"data": "not advertised under this name"})
        assert got.get(timeout=PATIENCE).data.startswith("not")
        enqueue(socket_, "unadvertise", topic="words")
        for op, fields, word in (
            ("publish", {"topic": "/words", "msg": {"date": "x"}}, "date"),
            ("publish", {"topic": "/words", "msg": {"data": 1}}, "data"),
            ("publish", {"topic": "/unknown", "msg": {}}, "type"),
            ("advertise", {"topic": "/words", "type": "std_msgs/Float64"}, "std_msgs/String"),
            ("advertise", {"topic": "/new", "type": "no_msgs/Type"}, "no_msgs"),
            ("advertise", {"topic": "/new", "type": "../x"}, "x"),
            ("advertise", {"topic": "/a b", "type": "std_msgs/String"}, "a b"),
        ):
            enqueue(socket_, op, id=word, **fields)
            answer = hear(socket_)
            assert (answer["op"], answer["level"], answer["id"]) == ("status", "error", word)
            assert word in answer["msg"]


def test_a_message_may_be_latched_without_advertising(serve: Serve, make_node: MakeNode) -> None:
    node = make_node("listener")
    got: queue.Queue[Any] = queue.Queue()
    node.subscribe("words", String, got.put)
    with client(serve(token="")) as socket_:
        enqueue(socket_, "publish", topic="/words", msg={"data": "kept"}, latch=True)
        assert got.get(timeout=PATIENCE).data == "kept"
        make_node("later").subscribe("words", String, got.put)
        assert got.get(timeout=PATIENCE).data == "kept"


def test_parts_of_a_client_advertise_the_same_topic(serve: Serve, make_node: MakeNode) -> None:
    """A topic ends with the last who has advertised it, and its subscribers stay connected until then."""
    got: queue.Queue[Any] = queue.Queue()
    node = make_node("listener")
    subscriber = node.subscribe("words", String, lambda message: got.put(message.data))
    with client(serve(token="")) as socket_:
        topic = {"topic": "/words", "type": "std_msgs/String"}
        enqueue(socket_, "advertise", **topic, id="one")
        enqueue(socket_, "publish", topic="/words", msg={"data": "1"})
        assert got.get(timeout=PATIENCE) == "1"
        (link,) = subscriber.links
        enqueue(socket_, "advertise", **topic, id="two", latch=True, queue_size=5)
        enqueue(socket_, "advertise", **topic, id="two", latch=True, queue_size=5)
        enqueue(socket_, "unadvertise", topic="/words", id="one")
        enqueue(socket_, "unadvertise", topic="/words", id="nobody")
        enqueue(socket_, "publish", topic="/words", msg={"data": "2"})
        assert got.get(timeout=PATIENCE) == "2"
        assert subscriber.links == (link,)
        later: queue.Queue[Any] = queue.Queue()
        make_node("later").subscribe("words", String, lambda message: later.put(message.data))
        assert later.get(timeout=PATIENCE) == "2"  # it is latched
        graph = Graph(node.master)
        assert graph.state().publishers["/words"] == ["/web"]
        enqueue(socket_, "unadvertise", topic="/words", id="two")
        settle(socket_)
        assert "/words" not in graph.state().publishers
        enqueue(socket_, "advertise", **topic, id="one")
        enqueue(socket_, "unadvertise", topic="/words")  # all
        settle(socket_)
        assert "/words" not in graph.state().publishers


def test_a_topic_that_another_client_has_just_begun(serve: Serve, make_node: MakeNode) -> None:
    got: queue.Queue[Any] = queue.Queue()
    server = serve(token="")
    with client(server) as one, client(server) as two:
        for number, kind in enumerate(("std_msgs/String", "std_msgs/Int32")):
            enqueue(one, "advertise", topic=f"/new{number}", type=kind)  # which asks the master before
            settle(one)
            assert ask(two, "/rosapi/topic_type", {"topic": f"/new{number}"})["values"] == {"type": kind}
            make_node(f"ear{number}").subscribe(f"new{number}", kind, lambda message: got.put(message.data))
            enqueue(two, "publish", topic=f"/new{number}", msg={"data": "x" if kind.endswith("String") else 5})
            enqueue(two, "subscribe", topic=f"/new{number}", type=kind)
            settle(two)
            topics = ask(two, "/rosapi/topics")["values"]
            assert dict(zip(topics["topics"], topics["types"], strict=True))[f"/new{number}"] == kind
    assert [got.get(timeout=PATIENCE) for _ in range(2)] == ["x", 5]


def test_the_last_words_of_a_client_are_heard(serve: Serve, make_node: MakeNode) -> None:
    got: queue.Queue[Any] = queue.Queue()
    make_node("listener").subscribe("words", String, lambda message: got.put(message.data))
    with client(serve(token="")) as socket_:
        enqueue(socket_, "advertise", topic="/words", type="std_msgs/String")
        for number in range(100):
            enqueue(socket_, "publish", topic="/words", msg={"data": str(number)})
    assert [got.get(timeout=PATIENCE) for _ in range(100)] == [str(number) for number in range(100)]


def test_subscribe(serve: Serve, make_node: MakeNode) -> None:
    publisher = make_node("talker").advertise("number", Float64, latch=True)
    publisher.publish(1.5)
    with client(serve(token="")) as socket_:
        enqueue(socket_, "subscribe", topic="number", id="a", type="std_msgs/Float64")
        assert hear(socket_) == {"op": "publish", "topic": "number", "msg": {"data": 1.5}}
        enqueue(socket_, "subscribe", topic="number", id="b", compression="cbor")
        assert hear(socket_)["msg"] == {"data": 1.5}  # who comes later gets the latched message, too
        publisher.publish(float("nan"))
        assert hear(socket_)["msg"]["data"] != 0
        enqueue(socket_, "unsubscribe", topic="number", id="b")
        settle(socket_)
        publisher.publish(float("nan"))
        assert hear(socket_)["msg"] == {"data": None}
        enqueue(socket_, "subscribe", topic="number", compression="cbor-raw", id="c")
        message = hear(socket_)["msg"]
        assert (len(message["bytes"]), message["secs"] > 0) == (8, True)
        enqueue(socket_, "unsubscribe", topic="number")
        settle(socket_)
        publisher.publish(2.5)
        enqueue(socket_, "subscribe", topic="/number", type="std_msgs/String", id="d")
        assert "std_msgs/Float64" in hear(socket_)["msg"]


@pytest.mark.parametrize("clients", [1, 3])
@pytest.mark.parametrize("compression", ["none", "cbor"])
def test_messages_of_any_size_arrive_in_order(
    serve: Serve, make_node: MakeNode, compression: str, clients: int
) -> None:
    """Small ones are sent as they arrive, larger ones after a thread has encoded them: none may overtake another."""
    publisher = make_node("talker").advertise("words", String, queue_size=1000)
    random = Random(clients)
    texts = [f"{number} " + "x" * random.choice([0, 0, 0, 10, 9_000, 40_000, 150_000]) for number in range(120)]
    server = serve(token="")
    with ExitStack() as stack:
        links = [stack.enter_context(client(server, max_queue=None)) for _ in range(clients)]
        for each in links:
            enqueue(each, "subscribe", topic="words", type="std_msgs/String", compression=compression)
            settle(each)
        for text in texts:
            publisher.publish(text)
            sleep(random.choice([0.0, 0.0, 0.001, 0.003]))
        for each in links:
            assert [hear(each)["msg"]["data"] for _ in texts] == texts


def test_messages_that_arrive_too_often_are_sent_later(serve: Serve, make_node: MakeNode) -> None:
    publisher = make_node("talker").advertise("number", Float64)
    with client(serve(token="")) as socket_:
        enqueue(socket_, "subscribe", topic="number", type="std_msgs/Float64", throttle_rate=100, queue_length=5)
        settle(socket_)
        for _ in range(2):  # the first message of a type takes another way than later ones
            for number in range(4):
                publisher.publish(float(number))
            assert [hear(socket_)["msg"]["data"] for _ in range(4)] == [0, 1, 2, 3]
            sleep(0.1)


def test_status_messages_as_the_client_wants_them(serve: Serve) -> None:
    with client(serve(token="")) as socket_:
        enqueue(socket_, "unsubscribe", topic="x")
        enqueue(socket_, "set_level", level="warning")
        enqueue(socket_, "unsubscribe", topic="y")
        assert hear(socket_) == {"op": "status", "level": "warning", "msg": "you do not subscribe to y"}
        enqueue(socket_, "set_level", level="none")
        enqueue(socket_, "dance")
        assert ask(socket_, "/rosapi/get_time")["result"]


def test_rosauth_is_refused_with_a_reason(serve: Serve) -> None:
    with client(serve(token="")) as socket_:
        enqueue(socket_, "auth", id="auth", mac="x", client="c", dest="d", rand="r", t=0, level="admin", end=0)
        answer = hear(socket_)
        assert (answer["op"], answer["level"], answer["id"]) == ("status", "error", "auth")
        assert "only `pyros1 web` needs a token" in answer["msg"]


@pytest.mark.parametrize("compression", ["none", "png", "cbor"])
def test_call_service(serve: Serve, make_node: MakeNode, compression: str) -> None:
    def add(request: Any) -> int:
        if request.a < 0:
            raise ValueError("too small")
        return int(request.a + request.b)

    make_node("adder").advertise_service("add", AddTwoInts, add)
    with client(serve(token="")) as socket_:
        answer = ask(socket_, "/add", [1, 2], compression=compression)
        if compression == "png":
            assert answer["op"] == "png"
            return
        assert answer == {
            "op": "service_response",
            "id": "call",
            "service": "/add",
            "values": {"sum": 3},
            "result": True,
        }
        for service, args, word in (
            ("/add", {"a": -1}, "too small"),
            ("/add", {"c": 1}, "c"),
            ("/nothing", {}, "/nothing"),
            ("/a b", {}, "a b"),
            ("/rosapi/nothing", {}, "nothing"),
            ("/rosapi/topic_type", {"topic": 1}, "topic"),
        ):
            answer = ask(socket_, service, args, compression=compression)
            assert (answer["id"], answer["result"]) == ("call", False)
            assert word in answer["values"]


def test_a_service_of_a_client(serve: Serve, make_node: MakeNode, capfd: pytest.CaptureFixture[str]) -> None:
    caller = make_node("caller")
    server = serve(token="")
    answers: queue.Queue[Any] = queue.Queue()

    def call() -> None:
        with caller.service("/switch", SetBool) as service:
            try:
                answers.put(service.call(SetBoolRequest(True), PATIENCE))
            except ServiceError as error:
                answers.put(str(error))

    def begin() -> None:
        thread = threading.Thread(target=call)
        thread.start()
        threads.append(thread)

    threads: list[threading.Thread] = []
    with client(server) as socket_:
        enqueue(socket_, "advertise_service", service="/switch", type="std_srvs/SetBool")
        settle(socket_)
        begin()
        request = hear(socket_)
        assert (request["op"], request["service"], request["args"]) == ("call_service", "/switch", {"data": True})
        enqueue(socket_, "service_response", id=request["id"], service="/else", result=True)
        assert hear(socket_)["level"] == "error"
        values = {"success": True, "message": "done"}
        enqueue(socket_, "service_response", id=request["id"], service="/switch", values=values, result=True)
        assert answers.get(timeout=PATIENCE).message == "done"
        begin()
        id = hear(socket_)["id"]
        enqueue(socket_, "service_response", id=id, service="/switch", values="broken", result=False)
        assert "broken" in answers.get(timeout=PATIENCE)
        begin()
        id = hear(socket_)["id"]
        enqueue(socket_, "service_response", id=id, service="/switch", values={"wrong": 1}, result=True)
        assert "wrong" in answers.get(timeout=PATIENCE)
        begin()
        id = hear(socket_)["id"]
        enqueue(socket_, "service_response", id=id, service="/switch", values={"success": []}, result=True)
        assert "sent an invalid response: field success is not a bool" in answers.get(timeout=PATIENCE)
        assert capfd.readouterr().err == ""
        begin()
        hear(socket_)
    assert "disconnected" in answers.get(timeout=PATIENCE)
    for thread in threads:
        thread.join(PATIENCE)


def test_a_client_that_comes_back_has_its_services_and_topics_again(serve: Serve, make_node: MakeNode) -> None:
    """Also while its old connection is not known to be dead; its end takes nothing from the new one."""
    caller = make_node("caller")
    server = serve(token="")
    answers: queue.Queue[Any] = queue.Queue()
    threads: list[threading.Thread] = []

    def begin(number: int) -> None:
        def call() -> None:
            with caller.service("/switch", SetBool) as service:
                answers.put((number, service.call(SetBoolRequest(True), PATIENCE).message))

        threads.append(threading.Thread(target=call))
        threads[-1].start()

    def introduce(socket_: ClientConnection, word: str) -> None:
        enqueue(socket_, "advertise_service", service="/switch", type="std_srvs/SetBool")
        enqueue(socket_, "advertise", topic="/state", type="std_msgs/String", latch=True)
        enqueue(socket_, "publish", topic="/state", msg={"data": word})
        settle(socket_)

    def answer(socket_: ClientConnection, request: Any, word: str) -> None:
        values = {"success": True, "message": word}
        enqueue(socket_, "service_response", id=request["id"], service="/switch", values=values, result=True)

    def state() -> str:
        heard: queue.Queue[str] = queue.Queue()
        with caller.subscribe("/state", String, lambda message: heard.put(message.data)) as subscriber:
            assert subscriber.wait_for_publishers(timeout=PATIENCE)
            return heard.get(timeout=PATIENCE)

    with client(server) as new:
        with client(server) as old:
            introduce(old, "old")
            begin(1)
            request = hear(old)
            introduce(new, "new")
            begin(2)
            answer(new, hear(new), "new")
            assert answers.get(timeout=PATIENCE) == (2, "new")
            answer(old, request, "old")  # it was asked before
            assert answers.get(timeout=PATIENCE) == (1, "old")
            enqueue(old, "unadvertise_service", service="/switch")
            settle(old)
            assert state() == "new"
        for number in (3, 4):
            begin(number)
            answer(new, hear(new), "new")
            assert answers.get(timeout=PATIENCE) == (number, "new")
            assert state() == "new"
            introduce(new, "new")  # the same client again
        make_node("other").advertise_service("/switch", SetBool, lambda request: {"message": "other"})
        introduce(new, "new")
        begin(5)
        answer(new, hear(new), "new")
        assert answers.get(timeout=PATIENCE) == (5, "new")
        enqueue(new, "advertise_service", service="/switch", type="std_srvs/Trigger")
        settle(new)
        assert ask(new, "/rosapi/service_type", {"service": "/switch"})["values"] == {"type": "std_srvs/Trigger"}
        enqueue(new, "advertise_service", service="/web/get_loggers", type="roscpp/GetLoggers")  # of the server's node
        assert "/web/get_loggers" in hear(new)["msg"]
    for thread in threads:
        thread.join(PATIENCE)


def test_a_client_that_goes_ends_its_calls(serve: Serve, make_node: MakeNode) -> None:
    called, go = threading.Event(), threading.Event()

    def slow(request: Any) -> dict[str, Any]:
        called.set()
        go.wait(PATIENCE)
        return {}

    make_node("slow").advertise_service("slow", SetBool, slow)
    server = serve(token="")
    with client(server) as socket_:
        enqueue(socket_, "call_service", service="/slow")
        assert called.wait(PATIENCE)
        answer = ask(socket_, "/slow", timeout=0.05)
        assert not answer["result"]
        assert ask(socket_, "/rosapi/get_time")["result"]
    go.set()


@pytest.mark.slow
def test_a_slow_client_gets_the_newest(serve: Serve, make_node: MakeNode) -> None:
    server = serve(token="")
    publisher = make_node("camera").advertise("image", Image, queue_size=0)
    with client(server, max_queue=1) as slow, client(server) as quick:
        for socket_ in (slow, quick):
            enqueue(socket_, "subscribe", topic="/image")
            settle(socket_)
        assert publisher.wait_for_subscribers(timeout=PATIENCE)
        data = bytes(1 << 20)
        count = 60
        for number in range(count):
            publisher.publish(height=number, data=data)
            while hear(quick)["msg"]["height"] != number:
                pass
        seen = [hear(slow)["msg"]["height"]]
        while seen[-1] != count - 1:
            seen.append(hear(slow)["msg"]["height"])
        assert seen == sorted(seen)
        assert len(seen) < count
        assert publisher.dropped == 0


def test_read_only(serve: Serve, make_node: MakeNode) -> None:
    make_node("adder").advertise_service("add", AddTwoInts, lambda request: 0)
    with client(serve(token="", read_only=True)) as socket_:
        for op, fields in (
            ("advertise", {"topic": "/x", "type": "std_msgs/String"}),
            ("publish", {"topic": "/x", "msg": {}}),
            ("advertise_service", {"service": "/x", "type": "std_srvs/SetBool"}),
        ):
            enqueue(socket_, op, **fields)
            assert "read-only" in hear(socket_)["msg"]
        for service in ("/add", "/rosapi/set_param", "/rosapi/delete_param"):
            answer = ask(socket_, service, {"name": "/x", "value": "1"} if "rosapi" in service else {})
            assert not answer["result"]
            assert "read-only" in answer["values"]
        assert ask(socket_, "/rosapi/services")["result"]


def test_only_some_topics(serve: Serve, make_node: MakeNode) -> None:
    node = make_node("talker")
    for name in ("/camera/image", "/secret"):
        node.advertise(name, Float64, latch=True).publish(1.0)
    node.advertise_service("/add", AddTwoInts, lambda request: 0)
    node.master.set_param("/secret", 1)
    with client(serve(token="", topics=("/camera/*",))) as socket_:
        assert ask(socket_, "/rosapi/topics")["values"]["topics"] == ["/camera/image"]
        assert ask(socket_, "/rosapi/services")["values"] == {"services": []}
        assert ask(socket_, "/rosapi/get_param_names")["values"] == {"names": []}
        for service, args in (
            ("/add", {}),
            ("/rosapi/get_param", {"name": "/secret"}),
            ("/rosapi/topic_type", {"topic": "/secret"}),
            ("/rosapi/publishers", {"topic": "/secret"}),
            ("/rosapi/service_type", {"service": "/add"}),
        ):
            assert "--topics" in ask(socket_, service, args)["values"]
        for op, fields in (
            ("subscribe", {"topic": "/secret"}),
            ("subscribe", {"topic": "secret"}),
            ("advertise", {"topic": "/secret", "type": "std_msgs/Float64"}),
            ("publish", {"topic": "/secret", "msg": {}}),
            ("advertise_service", {"service": "/x", "type": "std_srvs/SetBool"}),
        ):
            enqueue(socket_, op, **fields)
            assert "--topics" in hear(socket_)["msg"]


@pytest.mark.parametrize("frame", ["", "{}", b"\x00\xff", "[" * 100_000, '{"op": 1}', '{"op":"png","data":"aaaa"}'])
def test_a_client_that_sends_nonsense_is_told_so(serve: Serve, frame: str | bytes) -> None:
    with client(serve(token="")) as socket_:
        for _ in range(3):
            socket_.send(frame)
            assert hear(socket_)["level"] == "error"
        assert ask(socket_, "/rosapi/get_time")["result"]


def test_a_client_that_is_early_waits_for_the_servers_node(
    environ: dict[str, str], make_node: MakeNode, request: pytest.FixtureRequest
) -> None:
    make_node("talker").advertise("number", Float64, latch=True).publish(1.5)
    go = threading.Event()

    def late() -> Node:
        assert go.wait(PATIENCE)
        return Node("web", argv=[], environ=environ, handle_signals=False, rosout=False)

    robot = Robot(environ["ROS_MASTER_URI"], Access(token=""), late)
    request.addfinalizer(robot.close)
    server = Served(robot, robot.access)
    request.addfinalizer(server.close)
    robot.start()
    with client(server) as socket_:
        enqueue(socket_, "subscribe", topic="/number")
        assert socket_.ping().wait(PATIENCE)  # it was read
        go.set()
        assert hear(socket_)["msg"] == {"data": 1.5}


def test_an_answer_to_the_first_word_is_heard(serve: Serve, make_node: MakeNode) -> None:
    node = make_node("robot")
    echo = node.advertise("echo", String)
    node.subscribe("words", String, lambda message: echo.publish(message.data.upper()))
    server = serve(token="")
    for number in range(10):
        with client(server) as socket_:
            enqueue(socket_, "subscribe", topic="/echo", type="std_msgs/String")
            enqueue(socket_, "publish", topic="/words", msg={"data": f"word {number}"})
            assert hear(socket_)["msg"] == {"data": f"WORD {number}"}


@pytest.mark.parametrize("compression", ["none", "cbor", "cbor-raw"])
@pytest.mark.parametrize("size", [10, 500_000])
def test_messages_need_no_other_thread(
    serve: Serve, make_node: MakeNode, monkeypatch: pytest.MonkeyPatch, compression: str, size: int
) -> None:
    """Once nothing else is to be sent, the thread in which a message arrives sends it."""
    sent: queue.Queue[bool] = queue.Queue()
    send = SharedTransport.send

    def note(transport: SharedTransport, pieces: Any) -> bool:
        is_sent = send(transport, pieces)
        sent.put(is_sent)
        return is_sent

    publisher = make_node("talker").advertise("image", Image)
    with client(serve(token="")) as socket_:
        enqueue(socket_, "subscribe", topic="/image", compression=compression)
        settle(socket_)
        publisher.wait_for_subscribers(timeout=PATIENCE)
        publisher.publish(Image(data=bytes(size)))
        hear(socket_)
        monkeypatch.setattr(SharedTransport, "send", note)
        is_sent = False
        while not is_sent:  # the loop may still be busy with the one before
            publisher.publish(Image(data=bytes(size)))
            frame = hear(socket_)["msg"]
            assert "bytes" in frame or len(frame["data"]) >= size
            while not sent.empty():
                is_sent |= sent.get()
