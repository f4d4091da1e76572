"""registrar: nodes that start before their master, and masters that are restarted.

Feature: nodes survive a restart of the master -- they register again
"""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterator
from itertools import chain, repeat
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.ground.errors import MasterError, MasterUnreachableError, NodeShutdownError, ProtocolError
from pyros1.master.api import MasterApi
from pyros1.master.server import Master
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.msgs.std_srvs.srv import Empty
from pyros1.net.master_client import MasterClient
from pyros1.node.registrar import Registrar

from ..parts import context_of


@pytest.fixture
def late_master(free_port: int) -> Iterator[Any]:
    """Return a function that starts (again) a master on always the same port."""
    masters: list[Master] = []

    def start() -> Master:
        stop()
        masters.append(Master(port=free_port, bind_host="127.0.0.1"))
        masters[-1].start()
        return masters[-1]

    def stop() -> None:
        for master in masters:
            master.stop()

    start.stop = stop  # type: ignore[attr-defined]
    start.uri = f"http://localhost:{free_port}/"  # type: ignore[attr-defined]
    yield start
    stop()


@pytest.fixture
def environ(late_master: Any, tmp_path: Any) -> dict[str, str]:
    return {"ROS_MASTER_URI": late_master.uri, "ROS_HOSTNAME": "localhost", "ROS_HOME": str(tmp_path / "ros")}


@pytest.fixture(autouse=True)
def quick_checks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.node.registrar.CHECK_INTERVAL", 0.05)
    monkeypatch.setattr("pyros1.node.registrar.RETRY_DELAY", 0.02)


class Output:
    """Stands for sys.stderr; can be waited for."""

    def __init__(self) -> None:
        self.text = ""
        self.said = threading.Event()

    def write(self, text: str) -> None:
        self.text += text
        self.said.set()

    def flush(self) -> None: ...
    def isatty(self) -> bool:
        return False


def test_a_node_waits_for_its_master_and_says_so_p01(
    make_node: Any, late_master: Any, in_thread: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    stderr = Output()
    monkeypatch.setattr("sys.stderr", stderr)
    starting = in_thread(make_node, "early")
    said = stderr.said.wait(5)
    late_master()
    node = starting.join()
    assert said
    assert f"Unable to immediately register with master node [{late_master.uri}]" in stderr.text
    assert stderr.text.count("Unable to") == 1
    assert node.master.lookup_node("/early") == node.uri


def test_a_node_waits_for_a_master_that_ends_while_it_is_asked(
    make_node: Any, late_master: Any, in_thread: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    late_master()
    asked, go_on, stderr = threading.Event(), threading.Event(), Output()
    ask = MasterClient.multicall

    def pause_and_ask(master: MasterClient, calls: Any, **limits: Any) -> list[Any]:
        if not asked.is_set():
            master.ping()  # it is connected
            asked.set()
            assert go_on.wait(20)
        return ask(master, calls, **limits)

    monkeypatch.setattr(MasterClient, "multicall", pause_and_ask)
    monkeypatch.setattr("sys.stderr", stderr)
    starting = in_thread(make_node, "early")
    assert asked.wait(20)
    late_master.stop()
    go_on.set()
    assert stderr.said.wait(5)
    late_master()
    node = starting.join()
    assert node.master.lookup_node("/early") == node.uri


def test_patience_has_a_limit(make_node: Any, late_master: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(MasterUnreachableError, match=late_master.uri) as caught:
        make_node("early", wait_for_master=0.05)
    assert "pyros1 core" in str(caught.value), "says what to do"
    monkeypatch.setattr("pyros1.node.registrar.monotonic", lambda: 100.0)  # a coarse clock
    monkeypatch.setattr("pyros1.node.context.Context.pause", lambda context, seconds: pytest.fail("it waits"))
    with pytest.raises(MasterUnreachableError):
        make_node("early", wait_for_master=0)


def test_a_master_whose_host_is_unknown_is_said_to_be_that(
    make_node: Any, environ: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def look_up(host: str) -> list[str]:
        raise socket.gaierror(socket.EAI_NONAME, "Name or service not known")

    stderr = Output()
    monkeypatch.setattr("sys.stderr", stderr)
    monkeypatch.setattr("pyros1.net.resolve.resolve_host", look_up)
    times = chain([100.0, 100.0], repeat(101.0))  # the limit is over after the second try, however slow the first is
    monkeypatch.setattr("pyros1.node.registrar.monotonic", lambda: next(times))
    environ = {**environ, "ROS_MASTER_URI": "http://nowhere.invalid:11311"}
    with pytest.raises(MasterUnreachableError, match=r"add a line .ADDRESS nowhere\.invalid. to /etc/hosts"):
        make_node("early", environ=environ, wait_for_master=0.05)
    assert "the host name 'nowhere.invalid' cannot be resolved here: Name or service not known" in stderr.text
    assert "may not be running" not in stderr.text


def test_everything_is_registered_again_after_a_restart_of_the_master(
    make_node: Any, late_master: Any, watch_log: Any, collect: Any
) -> None:
    late_master()
    node, got = make_node("node"), collect()
    log = watch_log(node)
    node.advertise("a", Float64)
    node.subscribe("b", Float64, got)
    node.advertise_service("s", Empty, lambda request: {})
    node.params["/gain"] = 1
    assert node.params.cached("/gain") == 1
    before = node.master.get_system_state()
    late_master()
    log.saw("the master was restarted")
    while sorted(map(len, node.master.get_system_state())) != sorted(map(len, before)):
        pass
    assert [sorted(part) for part in node.master.get_system_state()] == [sorted(part) for part in before]
    other = make_node("other")
    publisher = other.advertise("b", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(2)
    got.wait()
    while node.params.cached("/gain", "gone") != "gone":
        pass
    other.params["/gain"] = 3
    while node.params.cached("/gain") != 3:
        pass


def test_a_registration_with_a_new_master_brings_all_others_along(
    make_node: Any, late_master: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.registrar.CHECK_INTERVAL", 60.0)
    late_master()
    node = make_node("node")
    node.advertise("a", Float64)
    late_master()
    node.advertise("b", Float64)  # before the registrar has looked
    topics = [name for name, _ in node.master.get_system_state()[0]]
    assert {"/a", "/b", "/rosout"} <= set(topics)


def test_subscriber_and_publisher_find_each_other_again(make_node: Any, late_master: Any, collect: Any) -> None:
    """Links stay up without a master; a publisher that is replaced meanwhile is found when the master is back."""
    late_master()
    got = collect()
    make_node("listener").subscribe("t", Float64, got)
    talker = make_node("talker")
    publisher = talker.advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    late_master.stop()
    publisher.publish(1)
    got.wait()
    talker.shutdown()
    late_master()
    again = make_node("talker").advertise("t", Float64)
    assert again.wait_for_subscribers(timeout=10)
    again.publish(2)
    got.wait(2)
    assert got.data == [1, 2]


def test_a_full_pipe_does_not_keep_a_node_from_registering(
    make_node: Any, late_master: Any, collect: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the registrar says of a master that was restarted need not be read by anybody."""
    held = threading.Event()

    class Full(Output):
        def write(self, text: str) -> None:
            assert held.wait(20), "written while it is full"
            super().write(text)

    late_master()
    got, out = collect(), Full()
    listener = make_node("listener", rosout=False)
    listener.subscribe("t", Float64, got)
    with monkeypatch.context() as patch:
        patch.setattr("sys.stdout", out)
        late_master()
        publisher = make_node("talker", rosout=False).advertise("t", Float64)
        assert publisher.wait_for_subscribers(timeout=10)
        listener.subscribe("later", Float64, got)
        publisher.publish(1)
        got.wait()
        held.set()
        listener.shutdown()
    assert "the master was restarted" in out.text


def test_registering_waits_while_the_master_is_away(
    make_node: Any, late_master: Any, watch_log: Any, in_thread: Any
) -> None:
    late_master()
    node = make_node("node")
    log = watch_log(node)
    late_master.stop()
    advertising = in_thread(node.advertise, "t", Float64)
    log.saw("does not answer; waiting", late_master.uri)
    late_master()
    advertising.join()
    assert "/t" in [name for name, _ in node.master.get_published_topics()]


def test_the_master_is_called_in_order(make_node: Any, late_master: Any) -> None:
    late_master()
    node = make_node("n", rosout=False)
    registrar = Registrar(context_of(node), node.master_uri, lambda *_: None, lambda: None)
    entry = ("registerPublisher", "/t", "std_msgs/Float64", node.uri)
    waits = [registrar.begin_register(*entry), registrar.begin_unregister(*entry)]
    registrar.start()
    for wait in waits:
        wait()
    assert "/t" not in {name for name, _ in node.master.get_system_state()[0]}
    registrar.close()


def test_unregistering_needs_no_master(make_node: Any, late_master: Any) -> None:
    late_master()
    node = make_node("node")
    publisher = node.advertise("t", Float64)
    late_master.stop()
    publisher.unregister()
    late_master()
    node.advertise("u", Float64)
    assert "/t" not in [name for name, _ in node.master.get_published_topics()]


@pytest.mark.parametrize("error", [MasterError("refused", 0), ProtocolError("nonsense")])
def test_unregistering_is_no_error_at_a_master_that_refuses_it(
    make_node: Any, late_master: Any, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    late_master()
    node = make_node("node")
    publishers = [node.advertise(name, Float64) for name in "tu"]

    def refuse(*_: object, **options: object) -> None:
        raise error

    with monkeypatch.context() as patch:
        patch.setattr(MasterClient, "call", refuse)
        for publisher in publishers:
            publisher.unregister()
    assert "/t" in [name for name, _ in node.master.get_published_topics()]


def test_a_registration_says_that_it_waits_although_a_check_has_noticed_it(
    make_node: Any, late_master: Any, in_thread: Any, watch_log: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    late_master()
    node = make_node("node")
    log = watch_log(node)
    failed = threading.Event()
    look_up = MasterClient.lookup_node

    def watched(client: MasterClient, name: str) -> str:
        try:
            return look_up(client, name)
        except MasterUnreachableError:
            failed.set()
            raise

    monkeypatch.setattr(MasterClient, "lookup_node", watched)
    late_master.stop()
    assert failed.wait(10)
    advertising = in_thread(node.advertise, "t", Float64)
    log.saw("does not answer; waiting")
    late_master()
    advertising.join()


def test_shutdown_while_the_master_is_away(make_node: Any, late_master: Any, in_thread: Any, watch_log: Any) -> None:
    late_master()
    node = make_node("node")
    log = watch_log(node)
    late_master.stop()
    advertising = in_thread(node.advertise, "t", Float64)
    log.saw("does not answer; waiting")
    node.shutdown()
    with pytest.raises(NodeShutdownError):
        advertising.join()


def test_shutdown_while_the_master_is_silent(
    make_node: Any, late_master: Any, in_thread: Any, monkeypatch: pytest.MonkeyPatch, free_port: int
) -> None:
    """A call of the master that is under way is given up, and no other is made."""
    monkeypatch.setattr("pyros1.node.registrar.UNREGISTER_TIMEOUT", 0.05)
    late_master()
    node = make_node("node")
    node.advertise("t", Float64)
    late_master.stop()
    with socket.create_server(("127.0.0.1", free_port)) as silent:
        silent.settimeout(10)
        with silent.accept()[0]:  # a check whether the master still knows the node
            ended = in_thread(node.shutdown)
            ended.join(timeout=5)


def test_a_master_that_falls_silent_at_the_end_of_a_node_delays_it_for_a_moment_only(
    make_node: Any, late_master: Any, in_thread: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.registrar.CHECK_INTERVAL", 60.0)
    monkeypatch.setattr("pyros1.node.registrar.UNREGISTER_TIMEOUT", 0.05)
    silent, ended, dispatch = threading.Event(), threading.Event(), MasterApi.dispatch

    def fall_silent(api: MasterApi, method: str, params: Any) -> Any:
        if method == "unregisterPublisher":
            silent.set()
            assert ended.wait(30)
        return dispatch(api, method, params)

    monkeypatch.setattr(MasterApi, "dispatch", fall_silent)
    late_master()
    node = make_node("node", rosout=False)
    node.advertise("t", Float64)
    ending = in_thread(node.shutdown)
    try:
        assert silent.wait(10)
        ending.join(timeout=5)
    finally:
        ended.set()


def test_a_clean_end_leaves_nothing_registered_t55(make_node: Any, late_master: Any) -> None:
    late_master()
    observer, node = make_node("observer"), make_node("node")
    node.advertise("a", Float64)
    node.subscribe("b", Float64, print)
    node.advertise_service("s", Empty, lambda request: {})
    node.shutdown()
    state = observer.master.get_system_state()
    assert not [name for part in state for name, nodes in part if "/node" in nodes]
    with pytest.raises(MasterError):
        observer.master.lookup_node("/node")


def test_unregistering_when_the_end_has_begun_is_no_error(make_node: Any, late_master: Any) -> None:
    """A thread that was about to unregister when another one ended the node: the end does it."""
    master, observer = late_master(), make_node("observer")
    context: Any = SimpleNamespace(name="/node", log=observer.log, stopping=threading.Event())
    registrar = Registrar(context, master.uri, lambda *_: None, lambda: None)
    registrar.start()
    registration = ("registerPublisher", "/t", "std_msgs/Float64", "http://localhost:1/")
    registrar.register(*registration)
    assert "/t" in published(observer.master)
    registrar.close()
    registrar.unregister(*registration)
    assert "/t" not in published(observer.master)
    with pytest.raises(NodeShutdownError):
        registrar.register(*registration)


def test_a_second_node_of_the_same_name_ends_the_first_m34_o01(
    make_node: Any, late_master: Any, watch_log: Any
) -> None:
    late_master()
    first = make_node("twin")
    log = watch_log(first)
    service = first.advertise_service("s", Empty, lambda request: {})
    second = make_node("twin")
    first.spin()  # ends
    first.shutdown()
    assert any("new node registered with same name" in text for text in log.texts)
    assert second.ok() and service is not None
    assert second.master.lookup_node("/twin") == second.uri


def test_what_a_new_master_was_not_told_is_told_at_the_next_check(
    make_node: Any, late_master: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A master that goes away in the middle of the registrations gets the rest when it is back."""
    late_master()
    node = make_node("node", rosout=False)
    for topic in ("a", "b", "c"):
        node.advertise(topic, Float64)
    call, failing = MasterClient.call, ["/b"]

    def flaky(client: MasterClient, method: str, *args: Any, **options: Any) -> Any:
        if method == "registerPublisher" and args[0] in failing:
            failing.clear()
            raise MasterUnreachableError("gone again")
        return call(client, method, *args, **options)

    monkeypatch.setattr(MasterClient, "call", flaky)
    late_master()
    until = time.monotonic() + 20
    while time.monotonic() < until:
        publishers = {name for name, _ in node.master.get_system_state()[0]}
        if publishers == {"/a", "/b", "/c"}:
            break
    assert publishers == {"/a", "/b", "/c"}
    assert not failing, "the interruption happened"


def test_a_registration_that_a_new_master_refuses_is_logged_and_the_others_are_made(
    make_node: Any, late_master: Any, watch_log: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    late_master()
    node = make_node("node", rosout=False)
    for topic in ("a", "b", "c"):
        node.advertise(topic, Float64)
    log = watch_log(node)
    call = MasterClient.call

    def refuse(client: MasterClient, method: str, *args: Any, **options: Any) -> Any:
        if method == "registerPublisher" and args[0] == "/b":
            raise MasterError("no such topic here", -1)
        return call(client, method, *args, **options)

    monkeypatch.setattr(MasterClient, "call", refuse)
    late_master()
    log.saw("registerPublisher of /b failed: no such topic here")
    node.advertise("d", Float64)
    assert published(node.master) == {"/a", "/c", "/d"}


def published(client: MasterClient) -> set[str]:
    return {topic for topic, _ in client.get_system_state()[0]}


def test_what_a_dead_master_could_not_be_told_is_told_when_it_goes_on(make_node: Any, late_master: Any) -> None:
    """It may go on with what it knew; the port of the node is still there, so nobody else would notice."""
    first = late_master()
    node = make_node("n")
    kept, ended = (node.advertise(topic, Float64) for topic in ("/kept", "/ended"))
    client = MasterClient("/n", late_master.uri)
    uri = client.lookup_node("/n")
    first.stop()
    ended.unregister()
    late_master()
    for topic in ("/kept", "/ended"):  # as the journal has it
        client.register_publisher(topic, "std_msgs/Float64", uri)
    until = time.monotonic() + 20
    while "/ended" in published(client):
        assert time.monotonic() < until
    assert "/kept" in published(client)
    kept.unregister()
    client.close()


def test_a_registrar_survives_a_malformed_answer(
    make_node: Any, late_master: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    late_master()
    node = make_node("n")
    node.advertise("/first", Float64)
    asked = threading.Event()

    def lookup_node(*_: object) -> str:
        asked.set()
        raise TypeError("'int' object is not iterable")

    with monkeypatch.context() as patch:
        patch.setattr(MasterClient, "lookup_node", lookup_node)
        assert asked.wait(20)
    node.advertise("/second", Float64)
    client = MasterClient("/me", late_master.uri)
    assert "/second" in published(client)
    client.close()
