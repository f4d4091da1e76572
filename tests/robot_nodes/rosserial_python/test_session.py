from __future__ import annotations

import random
from typing import Any

import pytest

from pyros1.msgs.rosserial_msgs.msg import Log, TopicInfo
from pyros1.msgs.rosserial_msgs.srv import RequestParamRequest, RequestParamResponse
from pyros1.robot_nodes.rosserial_python.session import (
    MAX_ENDPOINTS,
    TOPICS_REQUEST,
    BoardLog,
    Deliver,
    Endpoint,
    Kind,
    Say,
    Send,
    SendParameter,
    SendTime,
    Session,
    SetUp,
)

from ...bodies import encode
from .conftest import frame, topic_info

ASK = Send(TOPICS_REQUEST)
CHATTER = Endpoint(Kind.PUBLISHER, 125, "chatter", "std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", 512)


def announce(endpoint: Endpoint) -> bytes:
    return topic_info(endpoint.kind, *[getattr(endpoint, name) for name in ("id", "name", "type", "md5sum")])


def said(actions: list[Any]) -> list[str]:
    return [action.text for action in actions if isinstance(action, Say)]


def test_the_definitions_are_those_that_boards_were_built_with() -> None:
    assert TopicInfo._md5sum == "0ad51f88fc44892f8c10684077646005"
    assert Log._md5sum == "11abd731c25933261cd6183bd12d6295"
    assert RequestParamRequest._md5sum == "c1f3d28f1b044c871e6eff2e9fc3c667"
    assert RequestParamResponse._md5sum == "9f0e98bda65981986ddf53afa7a40e49"


def test_a_board_is_asked_announces_and_publishes() -> None:
    session = Session()
    assert session.start(0.0) == [ASK] and not session.is_synced
    assert session.receive(announce(CHATTER), 0.5) == [SetUp(CHATTER)] and session.is_synced
    assert session.receive(frame(125, b"\x02\0\0\0hi"), 0.6) == [Deliver(CHATTER, b"\x02\0\0\0hi")]


def test_time_log_and_parameters() -> None:
    session = Session()
    session.start(0.0)
    log = Log(level=Log.WARN, msg="battery low")
    request = RequestParamRequest("~pid")
    data = frame(10, bytes(8)) + frame(7, encode(log)) + frame(6, encode(request))
    assert session.receive(data, 0.1) == [SendTime(), BoardLog(Log.WARN, "battery low"), SendParameter("~pid")]


def test_a_silent_board_is_asked_again_and_again_but_reported_once() -> None:
    session = Session("is it 57600 baud?")
    actions = session.start(0.0)
    for tick in range(1, 400):
        actions += session.tick(tick / 10)
    assert actions.count(ASK) == 20
    assert len(said(actions)) == 1 and said(actions)[0].startswith("nothing came")


def test_garbage_alone_is_reported_with_what_to_check() -> None:
    session = Session("is it 57600 baud?")
    session.start(0.0)
    assert session.receive(b"Hello, world!", 1.0) == []
    assert said(session.tick(15.1)) == ["13 bytes came, but none that rosserial understands: is it 57600 baud?"]


def test_a_lost_board_is_reported_and_its_return_too() -> None:
    session = Session()
    session.start(0.0)
    session.receive(frame(10, bytes(8)), 1.0)
    assert session.tick(5.9) == []
    assert session.tick(6.1) == [ASK] and session.is_synced  # it may have been reset
    assert "lost the board" in said(session.tick(16.1))[0] and not session.is_synced
    assert said(session.tick(30.0)) == []
    actions = session.receive(frame(10, bytes(8)), 31.0)
    assert said(actions) == ["the board answers again"] and SendTime() in actions and session.is_synced
    assert said(session.receive(frame(10, bytes(8)), 32.0)) == []


def test_messages_of_unknown_topics_make_the_host_ask_but_not_each_time() -> None:
    session = Session()
    session.start(0.0)
    assert session.receive(frame(125, b""), 0.5) == []  # it was asked just now
    actions = session.receive(frame(125, b"") * 3, 5.0)
    assert actions.count(ASK) == 1 and len(said(actions)) == 1


def test_a_frame_that_pauses_is_given_up() -> None:
    session = Session()
    session.start(0.0)
    assert session.receive(b"\xff\xfe\xff\x7f\x81" + frame(10, bytes(8)), 1.0) == []
    assert session.tick(1.9) == []
    assert session.tick(2.1)[0] == SendTime()


def test_a_reprogrammed_board_may_use_an_id_for_another_topic() -> None:
    session = Session()
    session.start(0.0)
    other = Endpoint(Kind.SUBSCRIBER, 125, "led", "std_msgs/Empty", "d41d8cd98f00b204e9800998ecf8427e", 512)
    assert session.receive(announce(CHATTER) + announce(other), 0.1) == [SetUp(CHATTER), SetUp(other)]


@pytest.mark.parametrize("topic_id", [0, 5, 6, 7, 10, 11])
def test_topics_cannot_have_the_ids_of_the_protocol(topic_id: int) -> None:
    session = Session()
    session.start(0.0)
    actions = session.receive(topic_info(0, topic_id, "chatter", "std_msgs/String", "x"), 0.1)
    assert "not for topics" in said(actions)[0] and len(actions) == 1


def test_the_number_of_topics_is_limited() -> None:
    session = Session()
    session.start(0.0)
    data = b"".join(topic_info(0, 100 + number, "t", "std_msgs/String", "x") for number in range(MAX_ENDPOINTS + 1))
    actions = session.receive(data, 0.1)
    assert len(actions) == MAX_ENDPOINTS + 1 and "more than" in said(actions)[0]


def test_invalid_messages_with_right_checksums_are_reported() -> None:
    session = Session()
    session.start(0.0)
    for topic_id in (*Kind, 6, 7):
        assert "is not valid" in said(session.receive(frame(topic_id, b"\xff\xff\xff\xff"), 0.1))[0]


@pytest.mark.parametrize("seed", range(20))
def test_any_bytes_at_any_time_only_make_actions(seed: int) -> None:
    """Frames with random ids and data, cut, changed and mixed with garbage."""
    chance = random.Random(seed)
    session, now = Session(), 0.0
    session.start(now)
    for _ in range(200):
        now += chance.choice([0.01, 0.3, 3.0])
        data = bytearray(frame(chance.choice([*range(12), 125, 65535]), chance.randbytes(chance.randrange(30))))
        if chance.random() < 0.3:
            data[chance.randrange(len(data))] = chance.randrange(256)
        for action in session.receive(bytes(data[: chance.choice([5, 99])]), now) + session.tick(now):
            assert not isinstance(action, Deliver)
