"""peers: word of subscribers that come and go, and messages for one of them (P14).

Feature: notification when subscribers come and go, and messages to a single one of them -- `publisher.watch(joined,
    left)`
"""

from __future__ import annotations

from typing import Any

import pytest

from pyros1.ground.errors import SerializationError
from pyros1.msgs.geometry_msgs.msg import PointStamped
from pyros1.msgs.std_msgs.msg import Float64


def test_subscribers_that_come_and_go(make_node: Any, transport: str, collect: Any) -> None:
    came, left, first, second = collect(), collect(), collect(), collect()
    talker, a, b = make_node("talker"), make_node("a"), make_node("b")
    publisher = talker.advertise("t", Float64)

    def joined(peer: Any) -> None:
        peer.publish(Float64(1.5))
        came((peer.name, peer.others))

    watch = publisher.watch(joined, lambda peer: left((peer.name, peer.others)))
    subscriber = a.subscribe("t", Float64, first)
    assert came.wait() == [("/a", 0)]
    assert first.wait() and first.data == [1.5]
    b.subscribe("t", Float64, second)
    assert came.wait(2)[1] == ("/b", 1)
    second.wait()
    publisher.publish(2)
    first.wait(2)
    second.wait(2)
    assert first.data == second.data == [1.5, 2]
    assert {link.peer for link in publisher.links} == {"/a", "/b"}
    assert [link.header["callerid"] for link in subscriber.links] == ["/talker"]
    subscriber.unregister()
    assert left.wait() == [("/a", 1)]
    watch.close()
    b.shutdown()
    assert publisher.wait_for_subscribers(0)
    assert left.items == [("/a", 1)]


def test_those_that_are_there_already(make_node: Any, collect: Any) -> None:
    came, got = collect(), collect()
    publisher = make_node("talker").advertise("t", PointStamped)
    make_node("a").subscribe("t", PointStamped, got)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.watch(came)
    (peer,) = came.wait()
    peer.publish(PointStamped())
    publisher.publish(PointStamped())
    assert [message.header.seq for message in got.wait(2)] == [1, 2]
    with pytest.raises(SerializationError, match="/t: "):
        peer.publish(PointStamped(point="x"))


def test_a_function_that_raises(make_node: Any, collect: Any, watch_log: Any) -> None:
    node = make_node("talker")
    log = watch_log(node)
    publisher = node.advertise("t", Float64)
    publisher.watch(lambda peer: 1 / 0)
    make_node("a").subscribe("t", Float64, lambda _: None)
    log.saw("bad function for subscribers of /t", "ZeroDivisionError")
    assert publisher.num_connections == 1
