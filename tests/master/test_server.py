"""master.server and master.notify: the running master and the nodes it tells (M13, M34, M38, M39, M41, M53)."""

from __future__ import annotations

import errno
import queue
import socket
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import Any
from xmlrpc.client import ServerProxy

import pytest

from pyros1.ground.errors import (
    Error,
    MasterError,
    MasterMethodError,
    MasterUnreachableError,
    ParameterNotSetError,
    UnknownHostError,
)
from pyros1.master import Master
from pyros1.master.notify import MAX_QUEUED, Notifier
from pyros1.master.registry import Notice, Registry
from pyros1.net.loop import Loop
from pyros1.net.master_client import MasterClient
from pyros1.net.xmlrpc_server import XmlRpcServer


class Slave:
    """A node's API that writes down what it is told."""

    def __init__(self, loop: Loop) -> None:
        self.calls: list[list[Any]] = []
        self._arrived = threading.Semaphore(0)
        self._server = XmlRpcServer(loop, self._dispatch, bind_host="127.0.0.1", advertised_host="127.0.0.1")
        self.uri = self._server.uri
        self.close = self._server.close

    def _dispatch(self, method: str, params: Sequence[Any]) -> Any:
        self.calls.append([method, *params])
        self._arrived.release()
        return [1, "", 0]

    def wait(self, count: int) -> list[list[Any]]:
        for _ in range(count):
            assert self._arrived.acquire(timeout=10)
        got, self.calls = self.calls, []
        assert len(got) == count
        return got


@pytest.fixture
def lines() -> list[str]:
    return []


@pytest.fixture
def master(lines: list[str]) -> Iterator[Master]:
    master = Master(
        port=0,
        bind_host="127.0.0.1",
        advertised_host="127.0.0.1",
        log=lambda level, text: lines.append(text),
        notify_timeout=1.0,
    )
    master.start()
    yield master
    master.stop()


@pytest.fixture
def client(master: Master) -> Iterator[MasterClient]:
    client = MasterClient("/tester", master.uri)
    yield client
    client.close()


@pytest.fixture
def make_slave() -> Iterator[Callable[[], Slave]]:
    loop = Loop("slaves")
    loop.start()
    slaves: list[Slave] = []

    def make() -> Slave:
        slaves.append(Slave(loop))
        return slaves[-1]

    yield make
    for slave in slaves:
        slave.close()
    loop.stop()


def test_the_typed_client(master: Master, client: MasterClient) -> None:
    api = "http://127.0.0.1:9/"
    assert client.get_uri() == master.uri == f"http://127.0.0.1:{master.port}/"
    assert client.get_pid() > 0
    assert client.register_publisher("/t", "a/b", api) == []
    assert client.register_subscriber("/u", "a/b", api) == []
    client.register_service("/s", "rosrpc://h:1", api)
    assert client.lookup_service("/s") == "rosrpc://h:1"
    assert client.lookup_node("/tester") == api
    assert client.get_published_topics() == [["/t", "a/b"]]
    assert client.get_topic_types() == [["/t", "a/b"], ["/u", "a/b"]]
    assert client.get_system_state() == [[["/t", ["/tester"]]], [["/u", ["/tester"]]], [["/s", ["/tester"]]]]
    assert client.unregister_service("/s", "rosrpc://h:1") == 1
    assert client.unregister_subscriber("/u", api) == 1
    assert client.unregister_publisher("/t", api) == 1
    assert client.unregister_publisher("/t", api) == 0
    with pytest.raises(MasterError, match="unknown node") as caught:
        client.lookup_node("/tester")
    assert caught.value.code == -1
    with pytest.raises(MasterMethodError):
        client.call("nope")


def test_the_typed_client_and_parameters(client: MasterClient) -> None:
    client.set_param("/a/b", [1, "x", b"y"])
    assert client.get_param("/a") == {"b": [1, "x", b"y"]}
    assert client.has_param("/a/b")
    assert client.search_param("a") == "/a"
    assert client.search_param("zz") is None
    assert client.get_param_names() == ["/a/b"]
    client.delete_param("/a")
    assert not client.has_param("/a/b")
    for missing in (client.get_param, client.delete_param):
        with pytest.raises(ParameterNotSetError, match="/a"):
            missing("/a")
    assert client.subscribe_param("http://127.0.0.1:9/", "/a") == {}
    assert client.unsubscribe_param("http://127.0.0.1:9/", "/a") == 1


def test_m04_multicall(client: MasterClient) -> None:
    results = client.multicall([("setParam", ["/a", 1]), ("getParam", ["/a"]), ("getParam", ["/none"]), ("nope", [])])
    assert results[:2] == [0, 1]
    assert [type(result) for result in results[2:]] == [MasterError, MasterMethodError]


def test_no_master_is_said_clearly() -> None:
    with socket.create_server(("127.0.0.1", 0)) as unused:
        uri = f"http://127.0.0.1:{unused.getsockname()[1]}/"
    client = MasterClient("/tester", uri)
    with pytest.raises(MasterUnreachableError) as caught:
        client.get_pid()
    assert uri in str(caught.value)
    assert "ROS_MASTER_URI" in str(caught.value)
    with pytest.raises(MasterUnreachableError):
        client.get_param("/a")


def test_a_second_master_on_the_port_is_refused(master: Master) -> None:
    second = Master(port=master.port, bind_host="127.0.0.1")
    with pytest.raises(OSError) as caught:
        second.start()
    assert caught.value.errno == errno.EADDRINUSE
    second.stop()


def test_connections_that_cannot_be_accepted_are_logged(monkeypatch: pytest.MonkeyPatch) -> None:
    """The master's log says why clients wait: it can open no more files."""
    lines: queue.Queue[tuple[str, str]] = queue.Queue()
    accept, failures = socket.socket.accept, [errno.EMFILE]

    def fail_once(listener: socket.socket) -> tuple[socket.socket, Any]:
        if failures:
            raise OSError(failures.pop(), "Too many open files")
        return accept(listener)

    monkeypatch.setattr(socket.socket, "accept", fail_once)
    monkeypatch.setattr("pyros1.net.acceptor.RETRY_DELAY", 0.01)
    log: Callable[[str, str], object] = lambda level, text: lines.put((level, text))  # noqa: E731 - has a type
    master = Master(port=0, bind_host="127.0.0.1", advertised_host="127.0.0.1", log=log)
    master.start()
    client = MasterClient("/tester", master.uri)
    try:
        assert client.get_pid() > 0
    finally:
        client.close()
        master.stop()
    logged = list(lines.queue)
    assert [text for level, text in logged if level == "error" and "cannot accept a connection: Too many" in text]


def test_m13_shutdown_answers_first() -> None:
    reasons: list[str] = []
    master = Master(port=0, bind_host="127.0.0.1", on_shutdown=reasons.append)
    master.start()
    with ServerProxy(master.uri) as proxy:
        assert proxy.shutdown("/me", "enough") == [1, "shutdown", 0]
    assert master.wait(5)
    master.stop()
    master.stop()
    assert reasons == ["enough"]


def test_m38_m57_subscribers_are_told(client: MasterClient, make_slave: Callable[[], Slave], lines: list[str]) -> None:
    first, second = make_slave(), make_slave()
    client.register_subscriber("/t", "*", first.uri)
    other = MasterClient("/other", client.uri)
    other.register_subscriber("/t", "*", second.uri)
    other.close()
    publisher = MasterClient("/p", client.uri)
    assert publisher.register_publisher("/t", "a/b", "http://p:1/") == [first.uri, second.uri]
    update = ["publisherUpdate", "/master", "/t", ["http://p:1/"]]
    assert first.wait(1) == second.wait(1) == [update]
    publisher.unregister_publisher("/t", "http://p:1/")
    assert first.wait(1) == second.wait(1) == [["publisherUpdate", "/master", "/t", []]]
    publisher.close()
    start = f"publisherUpdate[/t] -> {first.uri} ['http://p:1/']"
    assert start in lines
    assert any(line.startswith(start + ": sec=0.") and line.endswith("result=[1, '', 0]") for line in lines)


def test_m39_o04_each_node_hears_in_order(client: MasterClient, make_slave: Callable[[], Slave]) -> None:
    slave = make_slave()
    for topic in ("/a", "/b"):
        client.register_subscriber(topic, "*", slave.uri)
    publisher = MasterClient("/p", client.uri)
    for _ in range(20):
        publisher.register_publisher("/a", "a/b", "http://p:1/")
        assert slave.wait(1)[0][2:] == ["/a", ["http://p:1/"]]
        publisher.unregister_publisher("/a", "http://p:1/")
        assert slave.wait(1)[0][2:] == ["/a", []]
    publisher.close()


def test_m34_m35_the_old_namesake_is_shut_down_and_its_subscribers_told(
    client: MasterClient, make_slave: Callable[[], Slave]
) -> None:
    old, new, listener = make_slave(), make_slave(), make_slave()
    client.register_subscriber("/t", "a/b", listener.uri)
    node = MasterClient("/n", client.uri)
    node.register_publisher("/t", "a/b", old.uri)
    assert listener.wait(1)[0][3] == [old.uri]
    node.register_subscriber("/u", "a/b", new.uri)
    assert old.wait(1) == [["shutdown", "/master", "[/n] Reason: new node registered with same name"]]
    assert listener.wait(1)[0][2:] == ["/t", []]
    node.close()


def test_m53_parameter_subscribers_are_told(client: MasterClient, make_slave: Callable[[], Slave]) -> None:
    slave = make_slave()
    listener = MasterClient("/listener", client.uri)
    assert listener.subscribe_param(slave.uri, "/p") == {}
    client.set_param("/p/q", 1)
    client.delete_param("/p")
    assert slave.wait(2) == [["paramUpdate", "/master", "/p/q/", 1], ["paramUpdate", "/master", "/p/", {}]]
    listener.set_param("/p", 2)
    client.set_param("/p", 3)
    assert slave.wait(1) == [["paramUpdate", "/master", "/p/", 3]]
    listener.close()


def test_m39_m41_dead_and_silent_nodes_delay_nobody(
    client: MasterClient, make_slave: Callable[[], Slave], lines: list[str]
) -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent, socket.create_server(("127.0.0.1", 0)) as closed:
        dead = f"http://127.0.0.1:{closed.getsockname()[1]}/"
        closed.close()
        slave = make_slave()
        for name, uri in (
            ("/silent", f"http://127.0.0.1:{silent.getsockname()[1]}/"),
            ("/dead", dead),
            ("/ok", slave.uri),
        ):
            other = MasterClient(name, client.uri)
            other.register_subscriber("/t", "*", uri)
            other.close()
        for _ in range(5):
            client.register_publisher("/t", "a/b", "http://p:1/")
            assert slave.wait(1)
        client.register_publisher("/t2", "a/b", "http://p:1/")
    assert any(line.startswith(f"publisherUpdate[/t] -> {dead}") and "failed" in line for line in lines)
    # The dead one is still registered: cleaning up is for people to do.
    assert client.lookup_node("/dead") == dead


class SlowCaller:
    """Stands in for RpcCaller; the test answers."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, str, list[Any], Callable[[Any, Error | None], object]]] = []

    def call(self, uri: str, method: str, params: list[Any], on_done: Callable[[Any, Error | None], object]) -> None:
        self.calls.append((uri, method, params, on_done))


def test_a_subscriber_that_cannot_be_reached_is_told_of_once() -> None:
    """It has a wrong address, and cannot know: it only gets no messages."""
    caller, told = SlowCaller(), list[str]()
    notifier = Notifier(caller, lambda level, text: None, told.append)  # type: ignore[arg-type] # a stand-in

    def send(method: str, error: Error | None) -> None:
        notifier.send([Notice("http://nobody:5/", "/scan", method, "/t", ([],))])
        caller.calls[-1][3](None if error else [1, "", 0], error)

    unknown = UnknownHostError("nobody", None)
    send("shutdown", unknown)
    send("publisherUpdate", MasterError("it says no", 0))
    assert told == []
    for _ in range(3):
        send("publisherUpdate", unknown)
    assert len(told) == 1
    assert "/scan cannot be notified of the publishers of /t" in told[0] and "export ROS_IP" in told[0]
    send("publisherUpdate", None)
    send("publisherUpdate", unknown)
    assert len(told) == 2


def test_a_subscriber_that_is_just_closing_is_not_told_of() -> None:
    """At Ctrl-C all nodes of a launch unregister and close at once: notices of the one reach the other too late."""
    caller, told, later = SlowCaller(), list[str](), list[Callable[[], object]]()
    registry = Registry()

    def call_later(seconds: float, function: Callable[..., object], *args: Any) -> None:
        later.append(lambda: function(*args))

    notifier = Notifier(caller, lambda level, text: None, told.append, registry.is_subscribed, call_later)  # type: ignore[arg-type] # a stand-in

    def fail() -> None:
        notifier.send([Notice("http://here:5/", "/scan", "publisherUpdate", "/t", ([],))])
        caller.calls[-1][3](None, UnknownHostError("here", None))

    registry.register_subscriber("/scan", "/t", "p/T", "http://here:5/")
    fail()
    registry.unregister_subscriber("/scan", "/t", "http://here:5/")
    later.pop()()
    assert told == [] and later == []

    registry.register_subscriber("/scan", "/t", "p/T", "http://here:6/")  # started again, on another port
    fail()
    later.pop()()
    assert told == []

    registry.register_subscriber("/scan", "/t", "p/T", "http://here:5/")
    fail()
    assert told == []
    later.pop()()
    assert len(told) == 1

    notifier.send([Notice("http://here:5/", "/scan", "publisherUpdate", "/t", ([],))])
    caller.calls[-1][3]([1, "", 0], None)  # reached again
    fail()
    notifier.send([Notice("http://here:5/", "/scan", "publisherUpdate", "/t", ([],))])
    caller.calls[-1][3]([1, "", 0], None)
    later.pop()()
    assert len(told) == 1, "it was out of reach for less than the time of the check"


def test_a_node_that_subscribes_again_hears_the_latest_last() -> None:
    """An update under way is older than the answer to registerSubscriber, and may come after it."""
    caller = SlowCaller()
    notifier = Notifier(caller, lambda level, text: None)  # type: ignore[arg-type] # a stand-in
    registry = Registry()

    def told() -> list[Any]:
        return [params[1:] for _, _, params, _ in caller.calls]

    def answer() -> None:
        caller.calls[-1][3]([1, "", 0], None)

    notifier.send(registry.register_subscriber("/s", "/t", "p/T", "uri"))
    assert told() == [], "its answer has said all"
    notifier.send(registry.register_publisher("/p", "/t", "p/T", "one"))
    registry.unregister_subscriber("/s", "/t", "uri")
    registry.register_publisher("/q", "/t", "p/T", "two")
    notifier.send(registry.register_subscriber("/s", "/other", "p/T", "uri"))
    notifier.send(registry.register_subscriber("/s", "/t", "p/T", "uri"))
    answer()
    assert told() == [["/t", ["one"]], ["/t", ["one", "two"]]]
    answer()
    notifier.send(registry.register_subscriber("/s", "/t", "p/T", "uri"))
    assert len(told()) == 2


def test_newer_notices_replace_those_that_wait_and_queues_are_bounded() -> None:
    caller = SlowCaller()
    notifier = Notifier(caller, lambda level, text: None)  # type: ignore[arg-type] # a stand-in

    def update(topic: str, number: int, node: str = "/n") -> Notice:
        return Notice("uri", node, "publisherUpdate", topic, ([number],))

    notifier.send([update("/a", 1), update("/a", 2), update("/b", 3), update("/a", 4), update("/a", 5, "/m")])
    assert len(caller.calls) == 1
    for _ in range(4):
        caller.calls[-1][3]([1, "", 0], None)
    assert [params[1:] for _, _, params, _ in caller.calls] == [["/a", [1]], ["/b", [3]], ["/a", [4]], ["/a", [5]]]
    notifier.send([update(f"/t{i}", i) for i in range(MAX_QUEUED + 10)])
    assert len(caller.calls) == 5
    sent = 0
    while len(caller.calls) > 4 + sent:
        sent += 1
        caller.calls[-1][3](None, Error("x"))
    assert sent == MAX_QUEUED + 1
