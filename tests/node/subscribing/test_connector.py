"""connector: publishers that are silent, refuse, talk nonsense or are not there; each costs only itself."""

from __future__ import annotations

import contextlib
import socket
import threading
from typing import Any

import pytest

from pyros1.ground.errors import UnknownHostError
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.wire.header import encode_header

from ...bodies import encode_frame
from ...parts import context_of, on_loop, subscription_of


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Many attempts in a short time."""
    monkeypatch.setattr("pyros1.node.subscribing.dialogue.MIN_BACKOFF", 0.01)
    monkeypatch.setattr("pyros1.node.subscribing.dialogue.MAX_BACKOFF", 0.02)


def frame(number: float) -> bytes:
    return encode_frame(Float64(number))


def requests(fake: Any) -> int:
    return len([method for method, _ in fake.calls.items if method == "requestTopic"])


NONSENSE: list[Any] = [
    [0, "failed", 0],
    [-1, "Not a publisher of [/t]", []],
    [1, "ready", []],
    [1, "ready", ["UDPROS", "localhost", 1]],
    [1, "ready", ["TCPROS", "localhost"]],
    [1, "ready", ["TCPROS", "localhost", 0]],
    [1, "ready", ["TCPROS", "localhost", 70000]],
    [1, "ready", ["TCPROS", 5, "localhost"]],
    [1, "ready", "TCPROS"],
    [],
    5,
    "ready",
    {},
]


@pytest.mark.parametrize("nonsense", NONSENSE, ids=str)
def test_nonsense_from_request_topic_is_asked_again(
    make_node: Any, fake_node: Any, collect: Any, nonsense: Any
) -> None:
    fake, got = fake_node("/fake"), collect()
    fake.answers["requestTopic"] = nonsense
    fake.publish("/t")
    make_node("listener").subscribe("t", Float64, got)
    assert fake.calls.until(lambda _: requests(fake) >= 3)
    fake.answers["requestTopic"] = [1, "ready", ["TCPROS", "localhost", fake.port]]
    fake.accept_subscriber().sendall(frame(1))
    got.wait()


def test_a_fault_from_request_topic_is_asked_again(make_node: Any, fake_node: Any, collect: Any) -> None:
    from pyros1.ground.errors import XmlRpcFault

    fake, got = fake_node("/fake"), collect()

    def answer(*_: Any) -> Any:
        if requests(fake) < 3:
            raise XmlRpcFault(1, "not today")
        return [1, "ready", ["TCPROS", "localhost", fake.port]]

    fake.answers["requestTopic"] = answer
    fake.publish("/t")
    make_node("listener").subscribe("t", Float64, got)
    fake.accept_subscriber().sendall(frame(1))
    got.wait()


def test_a_wrong_port_is_tried_again(make_node: Any, fake_node: Any, collect: Any, closed_port: int) -> None:
    fake, got = fake_node("/fake"), collect()
    fake.answers["requestTopic"] = [1, "ready", ["TCPROS", "localhost", closed_port]]
    fake.publish("/t")
    make_node("listener").subscribe("t", Float64, got)
    assert fake.calls.until(lambda _: requests(fake) >= 2)
    fake.answers["requestTopic"] = [1, "ready", ["TCPROS", "localhost", fake.port]]
    fake.accept_subscriber().sendall(frame(2))
    got.wait()


def test_a_publisher_that_closes_instead_of_answering(make_node: Any, fake_node: Any, collect: Any) -> None:
    fake, got = fake_node("/fake"), collect()
    fake.publish("/t")
    make_node("listener").subscribe("t", Float64, got)
    for _ in range(3):
        fake.accept()[0].close()
    fake.accept_subscriber().sendall(frame(1))
    got.wait()


def test_a_silent_publisher_is_given_up_and_tried_again(
    make_node: Any, fake_node: Any, collect: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, got = fake_node("/fake"), collect()
    fake.publish("/t")
    with monkeypatch.context() as patch:
        patch.setattr("pyros1.node.subscribing.connector.STEP_TIMEOUT", 0.5)
        make_node("listener").subscribe("t", Float64, got)
        sock, _ = fake.accept()
        sock.sendall(b"\x10\0")  # says a little, and no more
        assert sock.recv(1) == b"", "closed by the subscriber"
    while not got.items:  # the next attempt may still have the short time, which this thread may need for itself
        with contextlib.suppress(ConnectionError):
            fake.accept_subscriber().sendall(frame(1))
            got.until(bool, timeout=2)


def test_a_publisher_whose_api_is_silent(
    make_node: Any, master: Any, collect: Any, fake_node: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.subscribing.connector.STEP_TIMEOUT", 0.1)
    fake, got = fake_node("/fake"), collect()
    with socket.create_server(("127.0.0.1", 0)) as publisher_silent:
        publisher_silent.settimeout(10)
        fake.master.register_publisher(
            "/t", "std_msgs/Float64", f"http://localhost:{publisher_silent.getsockname()[1]}/"
        )
        make_node("listener").subscribe("t", Float64, got)
        for _ in range(2):  # asks, gives up, asks again
            sock, _ = publisher_silent.accept()
            sock.close()


def test_a_publisher_that_does_not_answer_is_named_once(
    make_node: Any, fake_node: Any, watch_log: Any, collect: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.subscribing.connector.STEP_TIMEOUT", 0.1)
    monkeypatch.setattr("pyros1.node.subscribing.connector.SILENCE_TIMEOUT", 0.05)
    fake, listener, got = fake_node("/fake"), make_node("listener"), collect()
    log = watch_log(listener)
    with socket.create_server(("127.0.0.1", 0)) as publisher_silent:
        publisher_silent.settimeout(10)
        uri = f"http://localhost:{publisher_silent.getsockname()[1]}/"
        fake.master.register_publisher("/t", "std_msgs/Float64", uri)
        listener.subscribe("t", Float64, got)
        sockets = [publisher_silent.accept()[0] for _ in range(3)]  # asked, given up, asked again
        log.saw("no messages of /t", uri, "does not answer")
        assert len([text for text in log.texts if "does not answer" in text]) == 1
        for sock in sockets:
            sock.close()


def test_an_answer_in_pieces_and_with_messages(make_node: Any, fake_node: Any, collect: Any) -> None:
    fake, got = fake_node("/fake"), collect()
    fake.publish("/t")
    make_node("listener").subscribe("t", Float64, got)
    sock, header = fake.accept()
    sock.setsockopt(6, 1, 1)  # TCP_NODELAY
    for byte in encode_header({"type": "std_msgs/Float64", "md5sum": header["md5sum"]}) + frame(1):
        sock.sendall(bytes([byte]))
    got.wait()


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        (encode_header({"error": "go away"}), "refused the connection: go away"),
        (encode_header({"type": "std_msgs/Float64"}), "without the field 'md5sum'"),
        (encode_header({"md5sum": Float64._md5sum}), "without the field 'type'"),
        (b"\xff\xff\xff\xff", "exceeds the limit"),
        (b"\x08\0\0\0\x04\0\0\0abcd", "no '='"),
    ],
)
def test_a_refusal_is_told_and_not_tried_again_until_the_master_announces(
    make_node: Any, fake_node: Any, watch_log: Any, collect: Any, answer: bytes, reason: str
) -> None:
    fake, listener, got = fake_node("/fake"), make_node("listener"), collect()
    log = watch_log(listener)
    fake.publish("/t")
    listener.subscribe("t", Float64, got)
    sock, _ = fake.accept()
    sock.sendall(answer)
    text = log.saw(reason)
    assert "refused" not in reason or fake.uri in text
    fake.listener.settimeout(0.05)
    with pytest.raises(TimeoutError):
        fake.accept()
    fake.listener.settimeout(10)
    fake.publish("/t")  # registers again: the master announces it
    fake.accept_subscriber().sendall(frame(1))
    got.wait()
    assert len([text for text in log.texts if reason in text]) == 1


def test_a_roscpp_publisher_sends_any_type_as_star(make_node: Any, fake_node: Any, collect: Any) -> None:
    fake, got = fake_node("/fake"), collect()
    fake.publish("/t")
    make_node("listener").subscribe("t", Float64, got)
    fake.accept_subscriber(type="*", md5sum="*").sendall(frame(1))
    got.wait()


def test_a_lost_link_is_made_again_while_the_master_lists_the_publisher_t51(
    make_node: Any, fake_node: Any, collect: Any
) -> None:
    fake, got = fake_node("/fake"), collect()
    fake.publish("/t")
    make_node("listener").subscribe("t", Float64, got)
    for number in range(3):
        sock = fake.accept_subscriber()
        sock.sendall(frame(number))
        got.wait(number + 1)
        sock.close()
    assert got.data == [0, 1, 2]


def test_a_publisher_that_left_is_not_tried_again(make_node: Any, fake_node: Any, collect: Any) -> None:
    fake, listener, got = fake_node("/fake"), make_node("listener"), collect()
    fake.publish("/t")
    subscriber = listener.subscribe("t", Float64, got)
    sock = fake.accept_subscriber()
    assert subscriber.wait_for_publishers(timeout=20)
    told = threading.Event()
    subscription = subscription_of(listener)
    update = subscription.update_publishers

    def watch(uris: list[str], complete: bool = True) -> None:
        update(uris, complete)
        told.set()

    subscription.update_publishers = watch
    fake.master.unregister_publisher("/t", fake.uri)
    assert told.wait(20)
    sock.sendall(frame(5))  # what it still has to say is heard (T46)
    got.wait()
    gone = threading.Event()
    subscription.change_listeners.append(gone.set)
    sock.close()
    assert gone.wait(20)
    fake.listener.settimeout(0.05)
    with pytest.raises(TimeoutError):
        fake.accept()


class Unregistered:
    """A publisher's node, whose listener the subscriber has connected to when the master is told that it has gone."""

    def __init__(self, fake: Any, subscription: Any) -> None:
        self.fake = fake
        self._told = threading.Semaphore(0)
        update = subscription.update_publishers

        def watch(uris: list[str], complete: bool = True) -> None:
            update(uris, complete)
            self._told.release()

        self.sock, header = fake.accept()
        self.topic = header["topic"]
        subscription.update_publishers = watch
        fake.master.unregister_publisher(self.topic, fake.uri)
        assert self._told.acquire(timeout=20)

    def publish_again(self) -> None:
        self.fake.publish(self.topic)
        assert self._told.acquire(timeout=20)


def test_a_connection_that_was_begun_goes_on_when_the_publisher_is_replaced(
    make_node: Any, fake_node: Any, collect: Any
) -> None:
    """It may be the new publisher that took it, and what that publishes at once must not be lost."""
    fake, listener, got = fake_node("/fake"), make_node("listener"), collect()
    fake.publish("/t")
    listener.subscribe("t", Float64, got)
    replaced = Unregistered(fake, subscription_of(listener))
    fields = {"callerid": "/fake", "topic": "/t", "type": "std_msgs/Float64", "md5sum": Float64._md5sum}
    replaced.sock.sendall(encode_header({**fields, "message_definition": "float64 data\n"}) + frame(1))
    got.wait()
    replaced.publish_again()
    replaced.sock.sendall(frame(2))
    assert got.wait(2) and got.data == [1, 2] and requests(fake) == 1


@pytest.mark.parametrize("before", [True, False])
def test_what_a_replaced_publisher_refused_is_tried_with_the_new_one(
    make_node: Any, fake_node: Any, collect: Any, before: bool
) -> None:
    fake, listener, got = fake_node("/fake"), make_node("listener"), collect()
    fake.publish("/t")
    listener.subscribe("t", Float64, got)
    replaced = Unregistered(fake, subscription_of(listener))
    if before:
        replaced.publish_again()
    replaced.sock.sendall(encode_header({"error": "it is of another type"}))
    if not before:
        assert replaced.sock.recv(1) == b"", "it has closed the connection"
        replaced.publish_again()
    fake.accept_subscriber().sendall(frame(1))
    got.wait()


def test_a_replaced_publisher_of_which_one_notice_came_is_tried_again(
    make_node: Any, fake_node: Any, collect: Any, call_node: Any
) -> None:
    """The master joins notices that wait: the list is the same before and after."""
    fake, listener, got = fake_node("/fake"), make_node("listener"), collect()
    fake.publish("/t")
    listener.subscribe("t", Float64, got)
    sock, _ = fake.accept()
    assert call_node(listener, "publisherUpdate", "/master", "/t", [fake.uri])[0] == 1
    on_loop(listener)
    sock.sendall(encode_header({"error": "it is of another type"}))  # that of the old one
    fake.accept_subscriber().sendall(frame(1))
    got.wait()


def test_unreachable_publishers_delay_no_other(
    make_node: Any, fake_node: Any, collect: Any, closed_port: int, transport: str
) -> None:
    """Dead, silent and nameless publishers are listed before the good one."""
    listener, got = make_node("listener"), collect()
    bad = [fake_node(f"/bad{index}") for index in range(3)]
    with socket.create_server(("127.0.0.1", 0)) as publisher_silent:
        uris = [
            f"http://localhost:{closed_port}/",
            f"http://localhost:{publisher_silent.getsockname()[1]}/",
            "http://no-such-host.invalid:1234/",
        ]
        for fake, uri in zip(bad, uris, strict=True):
            fake.master.register_publisher("/t", "std_msgs/Float64", uri)
        publisher = make_node("talker").advertise("t", Float64)
        listener.subscribe("t", Float64, got)
        assert publisher.wait_for_subscribers(timeout=20)
        publisher.publish(1)
        got.wait()


def test_unsubscribing_ends_all_attempts(make_node: Any, fake_node: Any) -> None:
    fake, listener = fake_node("/fake"), make_node("listener")
    fake.answers["requestTopic"] = [0, "not yet", 0]
    fake.publish("/t")
    subscriber = listener.subscribe("t", Float64, print)
    assert fake.calls.until(lambda _: requests(fake) >= 2)
    subscriber.unregister()
    on_loop(listener)
    before = requests(fake)
    ended = threading.Event()
    context_of(listener).loop.call_later(0.06, ended.set)  # three rests
    assert ended.wait(20)
    assert requests(fake) <= before + 1  # one may have been under way


def test_unsubscribing_closes_the_link(make_node: Any, fake_node: Any) -> None:
    fake, listener = fake_node("/fake"), make_node("listener")
    fake.publish("/t")
    subscriber = listener.subscribe("t", Float64, print)
    sock = fake.accept_subscriber()
    assert subscriber.wait_for_publishers(timeout=20)
    subscriber.unregister()
    assert sock.recv(1) == b""


def test_shutdown_in_the_middle_of_a_greeting(make_node: Any, fake_node: Any) -> None:
    fake, listener = fake_node("/fake"), make_node("listener")
    fake.publish("/t")
    listener.subscribe("t", Float64, print)
    sock, _ = fake.accept()
    listener.shutdown()
    assert sock.recv(1) == b""


def test_a_publisher_whose_host_is_unknown_is_warned_of_once(
    make_node: Any, fake_node: Any, collect: Any, watch_log: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    tries = collect()

    def look_up(host: str) -> list[str]:
        tries(host)
        raise socket.gaierror(socket.EAI_NONAME, "Name or service not known")

    monkeypatch.setattr("pyros1.net.resolve.resolve_host", look_up)
    monkeypatch.setattr("pyros1.net.resolve.NEGATIVE_TTL_S", 0.0)
    fake, listener = fake_node("/fake"), make_node("listener")
    log = watch_log(listener)
    fake.uri = "http://nowhere.invalid:5000/"
    fake.publish("/a")
    fake.publish("/b")
    listener.subscribe("a", Float64, collect())
    listener.subscribe("b", Float64, collect())
    line = log.saw("the host name 'nowhere.invalid' cannot be resolved here: Name or service not known")
    assert "http://nowhere.invalid:5000/" in line and "add a line 'ADDRESS nowhere.invalid' to /etc/hosts here" in line
    tries.wait(4)
    assert sum("nowhere" in text for text in log.texts) == 1


def test_of_many_unknown_hosts_only_so_many_are_remembered(make_node: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.node.context.MAX_UNKNOWN_HOSTS", 2)
    context = context_of(make_node("listener"))
    warnings: list[str] = []
    monkeypatch.setattr(context.log, "warn", lambda text, topic, uri, error, hint: warnings.append(error.host))
    for host in ("a", "b", "a", "c", "c", "a"):
        context.warn_unknown_host("/t", f"http://{host}:1/", UnknownHostError(host, None))
    assert warnings == ["a", "b", "c", "a"]


def test_data_at_an_unknown_host_is_warned_of(make_node: Any, fake_node: Any, collect: Any, watch_log: Any) -> None:
    fake, listener = fake_node("/fake"), make_node("listener")
    fake.answers["requestTopic"] = [1, "ready", ["TCPROS", "a host", 5000]]
    log = watch_log(listener)
    fake.publish("/t")
    listener.subscribe("t", Float64, collect())
    log.saw("no messages of /t", "the host name 'a host' cannot be resolved here")


def test_many_publishers_that_were_killed_cause_few_warnings(
    make_node: Any, watch_log: Any, closed_port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each names first what is likely, where all nodes use ROS_HOSTNAME=localhost."""
    monkeypatch.setattr("pyros1.node.subscribing.dialogue.REPORTED_BACKOFF", 0.02)
    node = make_node("listener")
    assert context_of(node).host == "localhost"
    log = watch_log(node)
    node.subscribe("t", Float64, print)
    killed = [f"http://localhost:{closed_port}/{number}" for number in range(31)]
    context_of(node).loop.run(subscription_of(node, "/t").update_publishers, killed)
    log.saw("no messages of /t", "Connection refused. Has it exited? Then run: pyros1 node cleanup")
    assert log.until(lambda _: sum("no messages" in text for text in log.texts) == 3)
    node.shutdown()
    log.saw("similar messages were suppressed")
    assert sum("no messages" in text for text in log.texts) == 3
    assert not any("another machine" in text for text in log.texts)
