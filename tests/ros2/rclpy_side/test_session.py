"""A session through rclpy, with one that has no network."""

from __future__ import annotations

import queue
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.rules.rules import Priority
from pyros1.bridge.transport.zenoh_link import LinkError
from pyros1.ground.errors import ServiceRefusal
from pyros1.ros2.rclpy_side.calls import RclpyCall
from pyros1.ros2.rclpy_side.graph_reader import process_id
from pyros1.ros2.rclpy_side.qos import to_rclpy
from pyros1.ros2.rclpy_side.session import DeclarationError, RclpySession
from pyros1.ros2.rclpy_side.type_classes import TypeClasses
from pyros1.ros2.zenoh.attachments import Attachment, decode_attachment
from pyros1.ros2.zenoh.names import DataKey
from pyros1.ros2.zenoh.qos import Qos
from pyros1.ros2_types.rclpy_packages import RclpyPackages

from ...bridge.conftest import PATIENCE, wait_until
from .fake_rclpy import QOS, Network, Node, install

BENCH, CLEAN = "lab_msgs/msg/Bench", "lab_msgs/srv/Clean"
THEIRS = b"their publisher."
THREADS = ("bridge: rclpy", "bridge: ROS 2's graph", "bridge: end of rclpy")


def key(name: str, type: str = BENCH) -> DataKey:
    return DataKey(7, name, type, "RIHS01_any")


class Running:
    """A session, and what it has passed on."""

    def __init__(self, network: Network) -> None:
        self.network = network
        self.tokens: queue.Queue[tuple[str, bool]] = queue.Queue()
        self.messages: queue.Queue[tuple[str, bytes, Attachment | None]] = queue.Queue()
        self.processes: set[str] = set()
        self.calls: queue.Queue[RclpyCall] = queue.Queue()
        self.session = RclpySession(
            "bridge",
            7,
            TypeClasses(RclpyPackages()),
            lambda token, is_there: self.tokens.put((token, is_there)),
            self.on_message,
            self.calls.put,
        )

    def on_message(self, key: DataKey, body: bytes, attachment: bytes, process: str) -> None:
        self.messages.put((key.name, body, decode_attachment(attachment)))
        self.processes.add(process)

    def publish(self, *names: str, subscribe: tuple[str, ...] = ()) -> None:
        publishers = {f"{name} /node": (key(name), Qos(), Priority.NORMAL) for name in names}
        self.session.declare(publishers, {key(name): Qos() for name in subscribe})

    def send(self, name: str, body: bytes) -> None:
        assert self.session.try_send(Send(f"{name} /node", b"", body, Priority.NORMAL))


@pytest.fixture
def running(prefix: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Running]:
    made = Running(install(monkeypatch))
    yield made
    made.session.close()
    assert not [thread.name for thread in threading.enumerate() if thread.name in THREADS]


def test_it_says_what_there_is(running: Running) -> None:
    node = Node(running.network, "mapper")
    token, is_there = running.tokens.get(timeout=PATIENCE)
    assert is_there and token.startswith("@ros2_lv/7/") and token.endswith("/NN/%/%/mapper")
    node.destroy_node()
    assert running.tokens.get(timeout=PATIENCE) == (token, False)


def test_messages_are_sent(running: Running) -> None:
    running.publish("/a", "/b")
    running.send("/a", b"one")
    running.send("/c", b"to nobody")
    first, second = running.network.publishers
    assert (first.name, first.sent, second.sent) == ("/a", [b"one"], [])
    running.publish("/b")
    assert running.network.publishers == [second], "that of /a has ended, and that of /b is the same"
    running.send("/a", b"late")
    assert first.sent == [b"one"]


def test_messages_are_received(running: Running) -> None:
    running.publish(subscribe=("/a",))
    running.network.publish("/a", b"one", THEIRS)
    running.network.publish("/a", b"two", THEIRS)
    came = [running.messages.get(timeout=PATIENCE) for _ in range(2)]
    assert came == [("/a", b"one", Attachment(1, 7, THEIRS)), ("/a", b"two", Attachment(2, 7, THEIRS))]


@pytest.mark.parametrize("tells_publishers", [True, False])
def test_own_messages_do_not_come_back(prefix: Path, monkeypatch: pytest.MonkeyPatch, tells_publishers: bool) -> None:
    running = Running(install(monkeypatch, tells_publishers=tells_publishers))
    try:
        running.publish("/a", subscribe=("/a",))
        running.send("/a", b"ours")
        running.network.publish("/a", b"theirs", THEIRS)
        name, body, origin = running.messages.get(timeout=PATIENCE)
        assert (name, body) == ("/a", b"theirs")
        assert origin is not None and origin.gid == (THEIRS if tells_publishers else bytes(16))
        assert running.processes == ({process_id(THEIRS)} if tells_publishers else {""})
    finally:
        running.session.close()


def test_latched_messages_of_publishers_that_are_not_named(prefix: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    network = install(monkeypatch, tells_publishers=False)
    latched = Qos(transient_local=True)
    for name in ("/map", "/map", "/odom"):
        for qos in (latched, Qos()):
            Node(network, "theirs").create_publisher(BENCH, name, to_rclpy(qos, QOS))
    running = Running(network)
    try:
        running.session.declare({}, {key("/map"): latched, key("/odom"): latched, key("/scan"): Qos()})
        for name in ("/map", "/odom", "/map", "/map", "/odom", "/scan", "/scan"):
            network.publish(name, b"x", THEIRS)
        came = [running.messages.get(timeout=PATIENCE) for _ in range(7)]
        sources = [(name, origin.gid[-1]) for name, _, origin in came if origin is not None]
        assert sources == [
            ("/map", 0),
            ("/odom", 0),
            ("/map", 1),
            ("/map", 0),
            ("/odom", 0),
            ("/scan", 0),
            ("/scan", 0),
        ]
    finally:
        running.session.close()


def test_all_is_made_in_one_thread(running: Running) -> None:
    running.publish("/a", subscribe=("/b",))
    assert running.session.session.threads == {THREADS[0]}


def test_what_cannot_be_declared(running: Running) -> None:
    running.network.errors["/b"] = RuntimeError("no more room")
    publishers = {name: (key(name), Qos(), Priority.NORMAL) for name in ("/a", "/b")}
    assert running.session.declare(publishers, {key("/c", "yard_msgs/msg/Tree"): Qos(), key("/d"): Qos()}) == {
        "/b": "no more room",
        "/c": "package yard_msgs is not installed in this ROS 2 installation",
    }
    assert {each.name for each in (*running.network.publishers, *running.network.subscriptions)} == {"/a", "/d"}
    del running.network.errors["/b"]
    assert running.session.declare(publishers, {}) == {} and len(running.network.publishers) == 2


def test_calls_of_ros2_are_answered_in_any_order(running: Running) -> None:
    running.session.declare({}, {}, [key("/clean", CLEAN)])
    responses = [running.network.call("/clean", word) for word in (b"kitchen", b"yard")]
    calls = [running.calls.get(timeout=PATIENCE) for _ in range(2)]
    assert [call.body for call in calls] == [b"kitchen", b"yard"] and calls[0].origin is not None
    calls[1].respond(b"clean yard")
    assert responses[1].get(timeout=PATIENCE) == b"clean yard"
    calls[1].drop()
    calls[0].respond(b"clean kitchen")
    assert responses[0].get(timeout=PATIENCE) == b"clean kitchen"


def test_a_call_without_a_response(running: Running, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.ros2.rclpy_side.session.RETRY_PERIOD", 60.0)  # it is no error after which to wait
    running.session.declare({}, {}, [key("/clean", CLEAN)])
    failed, answered = running.network.call("/clean", b"kitchen"), running.network.call("/clean", b"yard")
    running.calls.get(timeout=PATIENCE).fail("no water")
    running.calls.get(timeout=PATIENCE).respond(b"clean yard")
    assert answered.get(timeout=PATIENCE) == b"clean yard" and failed.empty()
    assert running.session.problem == ""


def test_an_error_of_rclpy_is_told(running: Running) -> None:
    def fail() -> None:
        raise ValueError("a mistake")

    running.session.session.executor.create_task(fail)
    wait_until(lambda: running.session.problem == "rclpy fails: a mistake", "it is told")
    running.publish("/a")
    wait_until(lambda: running.session.problem == "", "it goes on")


def test_calling(running: Running) -> None:
    running.session.declare({}, {}, (), [key("/clean", CLEAN)])
    (client,) = running.network.clients
    answers: list[bytes] = []
    caller = threading.Thread(
        target=lambda: answers.append(running.session.call(key("/clean", CLEAN), b"yard", PATIENCE))
    )
    caller.start()
    request, future = client.requests.get(timeout=PATIENCE)
    future.set_result(client.type.Response(b"clean yard"))
    caller.join(PATIENCE)
    assert (request, answers, client.removed) == (b"yard", [b"clean yard"], [future])


def test_a_service_that_does_not_respond(running: Running) -> None:
    running.session.declare({}, {}, (), [key("/clean", CLEAN)])
    (client,) = running.network.clients
    with pytest.raises(ServiceRefusal, match="does not respond"):
        running.session.call(key("/clean", CLEAN), b"", 0.05)
    assert len(client.removed) == 1
    client.is_ready = False
    with pytest.raises(ServiceRefusal, match="is not there"):
        running.session.call(key("/clean", CLEAN), b"", 0.05)
    with pytest.raises(ServiceRefusal, match="has no connection"):
        running.session.call(key("/other", CLEAN), b"", 0.05)


def test_a_bridge_that_ends_while_a_service_is_called(running: Running) -> None:
    running.session.declare({}, {}, (), [key("/clean", CLEAN)])
    (client,) = running.network.clients
    errors: queue.Queue[ServiceRefusal] = queue.Queue()

    def call() -> None:
        try:
            running.session.call(key("/clean", CLEAN), b"", PATIENCE)
        except ServiceRefusal as error:
            errors.put(error)

    threading.Thread(target=call, daemon=True).start()
    client.requests.get(timeout=PATIENCE)
    running.session.close()
    assert str(errors.get(timeout=PATIENCE)) == "the bridge is shutting down", "it is not the service's fault"


def test_calling_without_waiting(running: Running) -> None:
    running.session.declare({}, {}, (), [key("/clean", CLEAN)])
    (client,) = running.network.clients
    answers: queue.Queue[bytes | ServiceRefusal] = queue.Queue()

    def start(word: bytes, timeout: float = PATIENCE) -> None:
        running.session.start_call(key("/clean", CLEAN), word, timeout, answers.put)

    start(b"yard")
    request, future = client.requests.get(timeout=PATIENCE)
    future.set_result(client.type.Response(b"clean yard"))
    assert (request, answers.get(timeout=PATIENCE), client.removed) == (b"yard", b"clean yard", [future])
    start(b"attic", 0.01)
    assert "does not respond" in str(answers.get(timeout=PATIENCE)) and len(client.removed) == 2
    client.requests.get(timeout=PATIENCE)[1].set_result(client.type.Response(b"too late"))
    client.is_ready = False
    start(b"cellar")
    client.is_ready = True
    request, future = client.requests.get(timeout=PATIENCE)
    assert request == b"cellar", "it was sent once the service was there"
    client.is_ready = False
    start(b"garage", 0.01)
    assert "is not there" in str(answers.get(timeout=PATIENCE))
    running.session.close()
    assert "shutting down" in str(answers.get(timeout=PATIENCE)) and answers.empty(), "cellar"
    with pytest.raises(ServiceRefusal, match="no connection"):
        start(b"roof")


def test_another_name(running: Running) -> None:
    running.publish("/a")
    first = running.session.session
    running.session.rename("other")
    assert running.network.nodes == [("other", "/")] and not running.network.publishers
    running.publish("/a", subscribe=("/a",))
    running.send("/a", b"ours")
    running.network.publish("/a", b"theirs", THEIRS)
    assert running.messages.get(timeout=PATIENCE)[1] == b"theirs", "our own publisher is known by the new name"
    assert running.session.session is not first and running.network.publishers[0].owner == ("other", "/")


def test_another_name_that_rclpy_refuses(running: Running) -> None:
    running.publish("/a")
    running.network.errors["other"] = RuntimeError("no such name")
    with pytest.raises(DeclarationError, match="no such name"):
        running.session.rename("other")
    running.publish("/a", "/b")
    assert {each.owner for each in running.network.publishers} == {("bridge", "/")}, "the old node goes on"
    del running.network.errors["other"]
    running.session.rename("other")
    assert running.network.nodes == [("other", "/")] and not running.network.publishers


def test_calls_end_with_their_clients(running: Running) -> None:
    running.session.declare({}, {}, [], [key("/clean", CLEAN)])
    (client,) = running.network.clients
    answers: queue.Queue[bytes | ServiceRefusal] = queue.Queue()

    def call() -> None:
        try:
            answers.put(running.session.call(key("/clean", CLEAN), b"yard", 2 * PATIENCE))
        except ServiceRefusal as error:
            answers.put(error)

    running.session.start_call(key("/clean", CLEAN), b"attic", 2 * PATIENCE, answers.put)
    caller = threading.Thread(target=call)
    caller.start()
    for _ in range(2):
        client.requests.get(timeout=PATIENCE)
    running.session.rename("other")
    for _ in range(2):
        assert isinstance(answers.get(timeout=PATIENCE), ServiceRefusal)
    caller.join(PATIENCE)
    assert not caller.is_alive() and answers.empty()


def test_closing_ends_all_calls(running: Running) -> None:
    running.session.declare({}, {}, [key("/clean", CLEAN)], [key("/clean", CLEAN)])
    running.network.call("/clean", b"kitchen")
    running.calls.get(timeout=PATIENCE)
    errors: list[ServiceRefusal] = []

    def call() -> None:
        try:
            running.session.call(key("/clean", CLEAN), b"yard", 60)
        except ServiceRefusal as error:
            errors.append(error)

    caller = threading.Thread(target=call)
    caller.start()
    running.network.clients[0].requests.get(timeout=PATIENCE)
    begin = time.monotonic()
    running.session.close()
    caller.join(PATIENCE)
    assert time.monotonic() - begin < 1 and len(errors) == 1
    assert not running.network.contexts and not running.network.nodes


def test_the_domain(running: Running) -> None:
    assert running.network.domains == [7]


def test_rclpy_that_does_not_start(prefix: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rclpy", None)
    with pytest.raises(LinkError, match=r"rclpy cannot start: .*rclpy"):
        Running(Network())
    network = install(monkeypatch)
    monkeypatch.setattr(sys.modules["rclpy.node"], "Node", lambda *_, **__: 1 / 0)
    with pytest.raises(LinkError, match="rclpy cannot start: division by zero"):
        Running(network)
    assert not network.contexts
