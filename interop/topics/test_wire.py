"""The same bytes to pyros1 and to stock rospy: headers, refusals, probes. Stock is the reference, beside it."""

from __future__ import annotations

import struct

import pytest
import raw
from harness import Master, Peer

TEXT, MD5 = "std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1"
SET_BOOL_MD5 = "09fb03525b03e7ea1fd3992bafd87e16"

pytestmark = pytest.mark.ours_only


@pytest.fixture
def reference(master: Master) -> Peer:
    return master.shared("stock", "rospy")


def test_subscriber_header(ours: Peer, reference: Peer, master: Master, topic: str) -> None:
    """T06: the fields and values that a rospy subscriber with tcp_nodelay sends, but for the comments."""
    headers = []
    for node in (ours, reference):
        with raw.fake_publisher(master, topic, TEXT) as fake:
            node.subscribe(topic, TEXT)
            with fake.accept() as connection:
                headers.append(raw.read_header(connection))
            node.ask("unsub", topic, event=f"unsubscribed {topic}")
    mine, stock = headers
    assert (mine.pop("callerid"), stock.pop("callerid")) == (ours.name, reference.name)
    assert "string data" in mine.pop("message_definition") and "string data" in stock.pop("message_definition")
    assert mine == stock
    assert mine["tcp_nodelay"] == "1"


def publisher_reply(master: Master, node: Peer, name: str, **changes: str | None) -> dict[str, str]:
    """The header with which *node* answers a subscriber of the std_msgs/String topic *name*."""
    fields = {"callerid": "/hand", "topic": name, "type": TEXT, "md5sum": MD5, "tcp_nodelay": "1"}
    fields = {key: value for key, value in {**fields, **changes}.items() if value is not None}
    with raw.connect(*raw.publisher_address(master, node.name, name)) as connection:
        connection.sendall(raw.encode_header(fields))
        return raw.read_header(connection)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"md5sum": "*", "type": "*"},
        {"type": "other/Type"},
        {"tcp_nodelay": None},
        {"type": None},
        {"md5sum": "0" * 32},
        {"md5sum": "0" * 32, "type": "other/Type"},
        {"md5sum": None},
        {"callerid": None},
        {"topic": "/no/such/topic"},
    ],
    ids=str,
)
def test_publisher_header(ours: Peer, reference: Peer, master: Master, topic: str, changes: dict[str, str]) -> None:
    """T07-T13: same fields, same values, and a refusal where stock refuses."""
    replies = []
    for node in (ours, reference):
        name = f"{topic}/{node.kind}"
        node.advertise(name, TEXT)
        replies.append(publisher_reply(master, node, name, **changes))
    mine, stock = replies
    if "error" in stock:
        assert set(mine) == {"error"} and mine["error"]
        for value in (*changes, *(value for value in changes.values() if value)):
            if value in stock["error"]:
                assert value in mine["error"]
        return
    for each, node in zip(replies, (ours, reference), strict=True):
        assert each.pop("callerid") == node.name
        assert each.pop("topic") == f"{topic}/{node.kind}"
        assert "string data" in each.pop("message_definition")
    assert mine == stock


def test_unknown_and_missing_protocols(ours: Peer, reference: Peer, master: Master, topic: str) -> None:
    """S11: requestTopic's refusals have the same codes."""
    for node in (ours, reference):
        node.advertise(topic, TEXT)
    for arguments in ((topic, [["UDPROS"]]), (topic, []), ("/no/such/topic", [["TCPROS"]])):
        mine, stock = (master.node(node.name, "requestTopic", *arguments) for node in (ours, reference))
        assert (mine[0], mine[2]) == (stock[0], stock[2])


@pytest.mark.parametrize(
    "changes",
    [{}, {"md5sum": "*"}, {"probe": "1", "md5sum": "*"}, {"md5sum": "0" * 32}, {"md5sum": None},
     {"service": "/no/such/service"}, {"persistent": "1"}],
    ids=str,
)  # fmt: skip
def test_service_header(ours: Peer, reference: Peer, master: Master, topic: str, changes: dict[str, str]) -> None:
    """T23-T25, T31, T33."""
    replies = []
    for node in (ours, reference):
        name = f"{topic}/{node.kind}"
        node.serve(name, "std_srvs/SetBool")
        fields = {"callerid": "/hand", "service": name, "md5sum": SET_BOOL_MD5}
        fields = {key: value for key, value in {**fields, **changes}.items() if value is not None}
        with raw.connect(*raw.service_address(master, name)) as connection:
            connection.sendall(raw.encode_header(fields))
            replies.append(raw.read_header(connection))
            if "error" not in replies[-1] and "probe" not in changes:
                connection.sendall(struct.pack("<IB", 1, 1))
                assert raw.read_exactly(connection, 1) == b"\1"
                assert raw.read_frame(connection)[0] == 1
            if "persistent" not in changes:
                assert connection.recv(1) == b""
            else:
                connection.sendall(struct.pack("<IB", 1, 0))
                assert raw.read_exactly(connection, 1) == b"\1"
                assert raw.read_frame(connection)[0] == 0
    mine, stock = replies
    if "error" in stock:
        assert set(mine) == {"error"} and mine["error"]
        return
    for each, node in zip(replies, (ours, reference), strict=True):
        assert each.pop("callerid") == node.name
        assert each.pop("service") == f"{topic}/{node.kind}"
    assert {key: mine.get(key) for key in stock} == stock


@pytest.mark.parametrize("body", [b"\1\2", b"\1" * 100, b"\0\1\0\0\0"], ids=repr)
def test_bytes_behind_a_request(ours: Peer, reference: Peer, master: Master, topic: str, body: bytes) -> None:
    """G29: they are ignored."""
    answers = []
    for node in (ours, reference):
        name = f"{topic}/{node.kind}"
        node.serve(name, "std_srvs/SetBool")
        with raw.connect(*raw.service_address(master, name)) as connection:
            connection.sendall(raw.encode_header({"callerid": "/hand", "service": name, "md5sum": SET_BOOL_MD5}))
            raw.read_header(connection)
            connection.sendall(struct.pack("<I", len(body)) + body)
            answers.append((raw.read_exactly(connection, 1), raw.read_frame(connection)))
    assert answers[0] == answers[1] and answers[0][0] == b"\1"


def test_header_without_topic_or_service(ours: Peer, reference: Peer, master: Master, topic: str) -> None:
    """T04."""
    for node in (ours, reference):
        name = f"{topic}/{node.kind}"
        node.advertise(name, TEXT)
        with raw.connect(*raw.publisher_address(master, node.name, name)) as connection:
            connection.sendall(raw.encode_header({"callerid": "/hand", "md5sum": "*"}))
            assert "no topic or service name" in raw.read_header(connection)["error"]


def test_texts_that_are_not_utf8_are_repaired(ours: Peer, master: Master, topic: str) -> None:
    """A C++ publisher may send strings that are not UTF-8: they arrive with replacement characters, as in rospy."""
    source, rospy = master.shared("stock", "roscpp"), master.shared("stock", "rospy")
    source.advertise(topic, TEXT)
    for peer in (ours, rospy):
        peer.subscribe(topic, TEXT)
        peer.linked(topic)
    source.linked(topic, 2)
    sent = source.publish(topic, -1)
    received = ours.received(topic)
    assert received == rospy.received(topic) != sent
    ours.wait_line(f"(?=.*{TEXT})(?=.*not UTF-8).*")
    sent = source.publish(topic, 1)
    assert ours.received(topic) == sent
    ours.linked(topic, 1)


def test_silent_and_garbage_peers_harm_nobody(ours: Peer, master: Master, topic: str) -> None:
    ours.advertise(topic, TEXT)
    sink = master.shared("stock", "roscpp")
    address = raw.publisher_address(master, ours.name, topic)
    silent = [raw.connect(*address) for _ in range(20)]
    with raw.connect(*address) as garbage:
        garbage.sendall(b"\xff\xff\xff\x7f" + b"x" * 1000)
    try:
        sink.subscribe(topic, TEXT)
        ours.linked(topic)
        sink.linked(topic)
        sent = ours.publish(topic)
        assert sink.received(topic) == sent
    finally:
        for connection in silent:
            connection.close()
