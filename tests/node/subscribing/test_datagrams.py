"""datagrams: topics over UDP between our nodes (T57-T62); with roscpp's in interop."""

from __future__ import annotations

import errno
import socket
from typing import Any

import pytest

from pyros1.msgs.std_msgs.msg import Float64, String
from pyros1.net.allowlist import Allowlist
from pyros1.wire.datagram import split_frame
from pyros1.wire.header import decode_header, encode_header

from ...bodies import encode_frame
from ...parts import publication_of, subscription_of

UDP = {"transports": "udp"}


@pytest.fixture(autouse=True)
def apart(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nodes of one process do not find each other, and attempts come quickly."""
    monkeypatch.setattr("pyros1.node.subscribing.connector.find_local_context", lambda uri: None)
    monkeypatch.setattr("pyros1.node.subscribing.dialogue.MIN_BACKOFF", 0.01)


def transports(node: Any) -> list[str]:
    return [link[3] for link in _info(node) if link[4] != "/rosout"]


def _info(node: Any) -> list[Any]:
    from pyros1.net.xmlrpc_client import XmlRpcClient

    client = XmlRpcClient(node.uri)
    try:
        return list(client.call("getBusInfo", "/test")[2])
    finally:
        client.close()


def test_messages_small_and_large(make_node: Any, collect: Any) -> None:
    talker, listener, got = make_node("talker"), make_node("listener"), collect()
    subscriber = listener.subscribe("t", String, got, queue_size=100, **UDP)
    publisher = talker.advertise("t", String, queue_size=10)
    assert publisher.wait_for_subscribers(timeout=20) and subscriber.wait_for_publishers(timeout=20)
    texts = ["", "small", "x" * 1488, "y" * 1489, "z" * 60_000]
    for number, text in enumerate(texts):
        publisher.publish(text)
        got.wait(number + 1)
    assert got.data == texts
    assert got.items[0]._connection_header["callerid"] == "/talker"
    assert transports(talker) == transports(listener) == ["UDPROS"]
    assert publication_of(talker).links[0].bytes_sent == sum(len(text) + 8 for text in texts)


@pytest.mark.parametrize("size", [64, 9000, 65507])
def test_datagrams_have_the_size_that_is_wanted(
    make_node: Any, fake_node: Any, call_node: Any, collect: Any, size: int
) -> None:
    talker, listener, fake, got = make_node("talker"), make_node("listener"), fake_node("/fake"), collect()
    fake.publish("/t", "std_msgs/String")
    listener.subscribe("t", String, got, transports=("udp",), max_datagram_size=size)
    publisher = talker.advertise("t", String, latch=True)
    publisher.publish("x" * 8000)
    assert got.wait(1) and got.data == ["x" * 8000]
    _, (_, _, [[*_, offered]]) = fake.calls.wait(1)[0]
    assert offered == size
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 0))
        sock.settimeout(5)
        header = encode_header({"callerid": "/x", "topic": "/t", "type": "std_msgs/String", "md5sum": String._md5sum})
        offer = ["UDPROS", header[4:], "127.0.0.1", sock.getsockname()[1], size]
        assert call_node(talker, "requestTopic", "/x", "/t", [offer])[0] == 1
        assert len(sock.recv(1 << 16)) == min(size, 8 + 4 + 4 + 8000)


def test_an_address_that_the_system_refuses_leaves_no_socket(
    make_node: Any, call_node: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As that of a broadcast."""
    talker, made = make_node("talker"), []
    talker.advertise("t", Float64)

    class Kept(socket.socket):
        def __init__(self, *args: Any, **options: Any) -> None:
            super().__init__(*args, **options)
            made.append(self)

        def connect(self, address: Any) -> None:
            if self.type == socket.SOCK_DGRAM:
                raise PermissionError(errno.EACCES, "Permission denied")
            super().connect(address)

    header = encode_header({"callerid": "/x", "topic": "/t", "type": "std_msgs/Float64", "md5sum": Float64._md5sum})
    with monkeypatch.context() as patch:
        patch.setattr("pyros1.node.publishing.udp_link.socket.socket", Kept)
        reply = call_node(talker, "requestTopic", "/x", "/t", [["UDPROS", header[4:], "127.0.0.1", 9, 1500]])
    assert reply[0] != 1 and "cannot send datagrams to 127.0.0.1:9" in reply[1], reply
    assert [sock.fileno() for sock in made if sock.type == socket.SOCK_DGRAM] == [-1]
    assert not publication_of(talker).links


def test_a_latched_message_comes_first(make_node: Any, collect: Any) -> None:
    talker, got = make_node("talker"), collect()
    talker.advertise("t", Float64, latch=True).publish(5)
    make_node("listener").subscribe("t", Float64, got, **UDP)
    got.wait(1)
    assert got.data == [5]


def test_t62_tcp_where_there_is_no_udp(make_node: Any, fake_node: Any, collect: Any) -> None:
    fake, got = fake_node("/fake"), collect()
    fake.publish("/t")
    make_node("listener").subscribe("t", Float64, got, transports=("udp", "tcp"))
    fake.accept_subscriber().sendall(encode_frame(Float64(1)))
    got.wait(1)
    _, (_, topic, protocols) = next(call for call in fake.calls.items if call[0] == "requestTopic")
    assert topic == "/t" and [protocol[0] for protocol in protocols] == ["UDPROS", "TCPROS"]
    assert isinstance(protocols[0][1], bytes) and protocols[0][2] == "localhost" and protocols[0][4] == 1500


def test_a_publisher_without_udp_is_told_once(make_node: Any, fake_node: Any, watch_log: Any, collect: Any) -> None:
    fake, listener = fake_node("/fake"), make_node("listener")
    fake.answers["requestTopic"] = [0, "no supported protocol implementations", []]
    log = watch_log(listener)
    fake.publish("/t")
    listener.subscribe("t", Float64, print, **UDP)
    assert fake.uri in log.saw("does not send /t over UDP", "no supported protocol implementations")


def test_another_type_is_refused(make_node: Any, watch_log: Any) -> None:
    talker, listener = make_node("talker"), make_node("listener")
    there, here = watch_log(talker), watch_log(listener)
    talker.advertise("t", String)
    listener.subscribe("t", Float64, print, **UDP)
    there.saw("refused a UDP subscriber of /t", "topic types do not match")
    here.saw("/t", "topic types do not match: [std_msgs/Float64] vs. [std_msgs/String]")


ANSWERS = [
    (["UDPROS", "localhost", 5, 1, 1500, b""], "without the field"),
    (["UDPROS", "localhost", 5, 1, 1500, encode_header({"error": "no"})[4:]], "refused the connection: no"),
    (["UDPROS", "localhost", 5, 1, 1500, b"\1\0\0\0x"], "has no '='"),
]


@pytest.mark.parametrize(("answer", "reason"), ANSWERS)
def test_bad_answers_are_told(make_node: Any, fake_node: Any, watch_log: Any, answer: Any, reason: str) -> None:
    fake, listener = fake_node("/fake"), make_node("listener")
    log = watch_log(listener)
    fake.answers["requestTopic"] = [1, "", answer]
    fake.publish("/t")
    listener.subscribe("t", Float64, print, **UDP)
    log.saw(reason)


def test_nonsense_is_asked_again(make_node: Any, fake_node: Any, collect: Any) -> None:
    fake, got = fake_node("/fake"), collect()
    nonsense: Any = [["UDPROS"], ["UDPROS", 1, 2, 3, 4, 5], ["TCPROS"], "UDPROS", 5]
    fields = {"callerid": "/fake", "topic": "/t", "type": "std_msgs/Float64", "md5sum": Float64._md5sum}
    good = ["UDPROS", "localhost", fake.port, 42, 1500, encode_header(fields)[4:]]
    offers: list[Any] = []

    def answer(caller: str, topic: str, protocols: Any) -> Any:
        offers.append(protocols[0])
        return [1, "", nonsense.pop() if nonsense else good]

    fake.answers["requestTopic"] = answer
    fake.publish("/t")
    subscriber = make_node("listener").subscribe("t", Float64, got, **UDP)
    assert subscriber.wait_for_publishers(timeout=20)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.sendto(b"nonsense", ("127.0.0.1", offers[-1][3]))
        for data in split_frame(encode_frame(Float64(1)), 42, 0, 1500):
            sender.sendto(data, ("127.0.0.1", offers[-1][3]))
    got.wait(1)


OFFERS: list[Any] = [
    ["UDPROS"],
    ["UDPROS", "text", "localhost", 5, 1500],
    ["UDPROS", b"", "localhost", 0, 1500],
    ["UDPROS", b"", "localhost", 70000, 1500],
    ["UDPROS", b"", 5, "localhost", 1500],
    ["UDPROS", b"", "localhost", 5],
    ["UDPROS", b"", "localhost", 5, 1500],
    ["UDPROS", b"\1", "localhost", 5, 1500],
]


@pytest.mark.parametrize("offer", OFFERS, ids=str)
def test_bad_offers_are_refused_and_tcp_is_still_there(make_node: Any, call_node: Any, offer: Any) -> None:
    talker = make_node("talker")
    talker.advertise("t", Float64)
    code, reason, value = call_node(talker, "requestTopic", "/x", "/t", [offer])
    assert code == 0 and reason and not value
    assert not publication_of(talker).links
    assert call_node(talker, "requestTopic", "/x", "/t", [["TCPROS"]])[2][0] == "TCPROS"


def test_what_an_offer_is_answered_t59(make_node: Any, call_node: Any) -> None:
    talker = make_node("talker")
    talker.advertise("t", Float64)
    fields = {"callerid": "/x", "topic": "/t", "type": "std_msgs/Float64", "md5sum": Float64._md5sum}
    offer = ["UDPROS", encode_header(fields)[4:], "localhost", 9, 1400]
    code, _, (name, host, port, connection, size, header) = call_node(talker, "requestTopic", "/x", "/t", [offer])
    assert (code, name, host, size) == (1, "UDPROS", "localhost", 1400)
    assert isinstance(port, int) and isinstance(connection, int)
    known = {**fields, "callerid": "/talker", "message_definition": Float64._full_text}
    assert decode_header(header).items() >= known.items()


def test_there_is_an_end_to_subscribers(make_node: Any, call_node: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.node.publishing.publisher_links.MAX_LINKS", 3)
    talker = make_node("talker")
    talker.advertise("t", Float64)
    fields = {"callerid": "/x", "topic": "/t", "type": "std_msgs/Float64", "md5sum": Float64._md5sum}
    offer = ["UDPROS", encode_header(fields)[4:], "localhost", 9, 1500]
    answers = [call_node(talker, "requestTopic", "/x", "/t", [offer]) for _ in range(5)]
    assert [code for code, _, _ in answers] == [1, 1, 1, 0, 0] and "3 subscribers" in answers[-1][1]
    assert len({answer[2][3] for answer in answers[:3]}) == 3, "each has a number of its own"


def test_a_subscriber_that_has_gone_is_noticed(make_node: Any, collect: Any) -> None:
    talker, got = make_node("talker"), collect()
    publisher = talker.advertise("t", Float64)
    with make_node("listener").subscribe("t", Float64, got, **UDP):
        assert publisher.wait_for_subscribers(timeout=20)
        publisher.publish(1)
        got.wait(1)
    gone = collect()
    publication_of(talker).change_listeners.append(lambda: gone(None))
    while publisher.num_connections:  # the system says so after the first one in vain
        publisher.publish(2)
    assert gone.wait(1) and got.data == [1]


def test_a_publisher_that_has_gone_is_noticed_and_the_next_one_heard(make_node: Any, collect: Any) -> None:
    talker, listener, got, gone = make_node("talker"), make_node("listener"), collect(), collect()
    subscriber = listener.subscribe("t", Float64, got, **UDP)
    for number in range(3):
        publisher = talker.advertise("t", Float64)
        assert publisher.wait_for_subscribers(timeout=20) and subscriber.wait_for_publishers(timeout=20)
        publisher.publish(number)
        got.wait(number + 1)
        subscription_of(listener).change_listeners.append(lambda: gone(subscriber.num_connections))
        publisher.unregister()
        assert gone.until(lambda counts: 0 in counts)
        subscription_of(listener).change_listeners.clear()
        gone.items.clear()
    assert got.data == [0, 1, 2]


@pytest.mark.slow
def test_who_does_not_keep_up_loses_messages_and_holds_nobody_up(make_node: Any, in_thread: Any, collect: Any) -> None:
    import threading

    talker, listener, got = make_node("talker"), make_node("listener"), collect()
    go_on = threading.Event()

    def heard(message: Any) -> None:
        go_on.wait(10)
        got(message)

    subscriber = listener.subscribe("t", Float64, heard, **UDP)
    publisher = talker.advertise("t", Float64, queue_size=None)
    assert publisher.wait_for_subscribers(timeout=20) and subscriber.wait_for_publishers(timeout=20)
    for number in range(20_000):
        publisher.publish(number)
    go_on.set()
    other = collect()
    with listener.subscribe("other", Float64, other, **UDP):
        late = talker.advertise("other", Float64)
        assert late.wait_for_subscribers(timeout=20)
        late.publish(1)
        other.wait(1)  # the loop is not held up
    assert 0 < len(got.items) <= 20_000 and got.data == sorted(got.data)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"transports": ()}, "transports"),
        ({"transports": ("tcp", "carrier pigeon")}, "carrier pigeon"),
        ({"transports": "UDP"}, "not .'UDP'"),
        ({"transports": None}, "None"),
        ({"transports": ("udp",), "max_datagram_size": 10}, "64 to 65507"),
        ({"transports": ("udp",), "max_datagram_size": 70000}, "64 to 65507"),
    ],
)
def test_wrong_hints_are_refused(make_node: Any, options: Any, text: str) -> None:
    with pytest.raises(ValueError, match=text):
        make_node("listener").subscribe("t", Float64, print, **options)


@pytest.mark.parametrize("max_senders", [1, 100])
def test_datagrams_of_hosts_that_may_not_connect_are_passed_over(
    make_node: Any, environ: dict[str, str], collect: Any, monkeypatch: pytest.MonkeyPatch, max_senders: int
) -> None:
    """However many senders there are, each is asked about again only if there are too many to remember."""
    monkeypatch.setattr("pyros1.node.subscribing.udp_source.MAX_SENDERS", max_senders)
    listener, got, asked = make_node("listener", environ={**environ, "PYROS1_ALLOW": "10.0.0.0/8"}), collect(), []
    talker, subscriber = make_node("talker"), listener.subscribe("t", Float64, got, queue_size=100, **UDP)
    publisher = talker.advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=20) and subscriber.wait_for_publishers(timeout=20)

    def admit(allowlist: Allowlist, peer: str, local_address: str) -> bool:
        asked.append(peer)
        return peer != "127.0.0.2"

    monkeypatch.setattr(Allowlist, "admit_address", admit)
    connection = publication_of(talker).links[0].topic_response("talker")[3]
    port = int(subscriber.links[0].address.split(" port ")[1].split()[0])
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.2", 0))
        for number in range(3):
            for data in split_frame(encode_frame(Float64(-1)), connection, number, 1500):
                other.sendto(data, ("127.0.0.1", port))
            publisher.publish(number)
    got.wait(3)
    assert got.data == [0, 1, 2]
    assert asked == ["127.0.0.2", "127.0.0.1"] * (3 if max_senders == 1 else 1)
