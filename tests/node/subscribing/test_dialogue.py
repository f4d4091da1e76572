"""dialogue: in every order of events a publisher is asked, told of, rested from and forgotten as it should be."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from pyros1.ground.errors import ProtocolError, UnknownHostError, UnreachableError, XmlRpcFault
from pyros1.node.subscribing import dialogue as do
from pyros1.node.subscribing.dialogue import IN_PROGRESS, MAX_BACKOFF, MIN_BACKOFF, REPORTED_BACKOFF, Dialogue, State
from pyros1.wire.handshake import TopicType
from pyros1.wire.header import encode_header

FLOAT = TopicType("std_msgs/Float64", "fdb28210bfa9d7c91146260178d9a584", "float64 data\n")
GOOD = {"callerid": "/talker", "type": FLOAT.name, "md5sum": FLOAT.md5sum, "latching": "0"}
SENT = {"callerid": "/listener", "topic": "/t", "type": FLOAT.name, "md5sum": FLOAT.md5sum}
URI = "http://talker:1/"


def make(**options: Any) -> Dialogue:
    return Dialogue("/t", URI, lambda: FLOAT, **options)


def test_the_way_to_a_publisher() -> None:
    talk = make()
    assert talk.on_publisher_listed() == [do.EndAttempt(), do.RequestTopic(report_silence=True)]
    assert talk.on_topic_response([1, "ready", ["TCPROS", "talker", 5000]]) == [do.Connect("talker", 5000)]
    assert talk.on_connected(SENT) == [do.SendHeader(SENT)]
    data = encode_header(GOOD)
    assert [talk.on_received(bytes([byte])) for byte in data[:-1]] == [[]] * (len(data) - 1)
    assert talk.on_received(data[-1:] + b"first") == [do.Link(GOOD, b"first")]
    assert talk.state is State.LINKED
    assert talk.on_publisher_unlisted() == [], "its last messages are not lost"
    assert talk.on_link_lost(None) == [do.EndAttempt(), do.Forget()]


def test_the_local_transport_is_offered_until_it_fails_and_again_after_news() -> None:
    talk, answer = make(), [1, "ready", ["PYROS1-LOCAL", "name"]]
    assert talk.offers_local
    talk.on_publisher_listed()
    assert talk.on_topic_response(answer) == [do.ConnectLocal("name")]
    assert talk.on_local_connect_failed() == [do.EndAttempt(), do.RequestTopic(report_silence=True)]
    assert not talk.offers_local
    assert talk.on_topic_response(answer)[-1] == do.Backoff(MIN_BACKOFF), "it was not offered"
    talk.on_publisher_listed()
    assert talk.offers_local and talk.on_topic_response(answer) == [do.ConnectLocal("name")]


def test_datagrams() -> None:
    header = encode_header(GOOD)[4:]
    answer = [1, "", ["UDPROS", "talker", 6000, 7, 1500, header]]
    talk = make()
    talk.on_publisher_listed()
    assert talk.on_topic_response(answer)[-1] == do.Backoff(MIN_BACKOFF), "none were offered"
    talk.on_backoff_over()
    assert talk.on_topic_response(answer, datagrams_offered=True) == [do.LinkDatagrams(GOOD, ("talker", 6000), 7)]
    assert talk.on_publisher_unlisted() == [do.EndDatagrams()], "no datagram says so"
    assert talk.on_link_lost(None) == [do.EndAttempt(), do.Forget()]
    talk = make(accepts_tcp=False)
    talk.on_publisher_listed()
    told, dropped = talk.on_topic_response([0, "no", 0], datagrams_offered=True)
    assert "does not send /t over UDP: no" in told.args[0] and dropped == do.EndAttempt()  # type: ignore[union-attr]
    assert talk.state is State.REFUSED


def test_a_publisher_that_cannot_be_reached_is_named_once_and_with_the_cure() -> None:
    """Not at once: one that has just ended is about to be forgotten by the master."""
    talk, told = make(), []
    publisher_refused = UnreachableError("cannot connect to localhost:5000: Connection refused")
    publisher_refused.__cause__ = ConnectionRefusedError()
    talk.on_publisher_listed()
    for attempt in range(12):
        if attempt:
            talk.on_backoff_over()
        talk.on_topic_response([1, "ready", ["TCPROS", "localhost", 5000]])
        told.append(
            [action for action in talk.on_attempt_failed(publisher_refused) if isinstance(action, do.LogMessage)]
        )
    assert [len(actions) for actions in told] == [0] * 5 + [1] + [0] * 6
    (tell,) = told[5]
    text = tell.text % tell.args
    assert "no messages of /t" in text and URI in text and "localhost:5000: Connection refused" in text
    assert "unset ROS_HOSTNAME" in text, "where its topics are is what counts, not its API"
    assert not tell.is_error


def test_the_silent_place_is_named() -> None:
    talk = make()
    talk.on_publisher_listed()
    (tell,) = talk.on_publisher_silent()
    assert isinstance(tell, do.LogMessage) and "talker:1 does not answer" in tell.text % tell.args
    talk.on_topic_response([1, "ready", ["TCPROS", "elsewhere", 5000]])
    (tell,) = talk.on_publisher_silent()
    assert isinstance(tell, do.LogMessage) and "elsewhere:5000 does not answer" in tell.text % tell.args


def test_rests_become_longer_until_there_is_a_link_or_news() -> None:
    talk = make()
    talk.on_publisher_listed()
    rests = []
    for _ in range(12):
        rests.append(talk.on_attempt_failed()[-1].seconds)  # type: ignore[union-attr]
        talk.on_backoff_over()
    assert rests == [min(MIN_BACKOFF * 2**count, MAX_BACKOFF) for count in range(12)]
    talk.on_attempt_failed()
    talk.on_publisher_listed()
    assert talk.on_attempt_failed()[-1] == do.Backoff(MIN_BACKOFF)
    talk.on_backoff_over()
    talk.on_attempt_failed()
    talk.on_backoff_over()
    talk.on_linked()
    assert talk.on_link_lost("reset")[-1] == do.Backoff(MIN_BACKOFF)


def test_another_programs_answer_is_told_once_until_there_is_a_link_or_news() -> None:
    talk = make()
    for _ in range(2):
        talk.on_publisher_listed()
        told, *rest = talk.on_attempt_failed(ProtocolError("http://talker:1/ answered with HTTP status 404"))
        assert isinstance(told, do.LogMessage) and told.args[:2] == ("/t", URI)
        assert told.args[2].endswith("HTTP status 404") and "another program taken the port" in told.args[3]
        assert rest == [do.EndAttempt(), do.Backoff(MIN_BACKOFF)]
        talk.on_backoff_over()
        assert talk.on_attempt_failed(XmlRpcFault(1, "no such method"))[0] == do.EndAttempt()
    talk.on_backoff_over()
    talk.on_linked()
    talk.on_link_lost(None)
    talk.on_backoff_over()
    assert isinstance(talk.on_attempt_failed(ProtocolError("no HTTP"))[0], do.LogMessage)


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        ([-1, "Not a publisher of [/t]", []], "it answers: Not a publisher of [/t]"),
        ("hello", "it does not answer like a node"),
        (UnreachableError("Connection refused"), "Connection refused"),
    ],
)
def test_what_may_be_a_node_that_ends_is_told_only_if_it_lasts(answer: Any, words: str) -> None:
    talk = make()
    talk.on_publisher_listed()
    rests, told = [], []
    for _ in range(12):
        *said, _, rest = (
            talk.on_attempt_failed(answer) if isinstance(answer, Exception) else talk.on_topic_response(answer)
        )
        rests.append(rest.seconds)  # type: ignore[union-attr]
        told += [(rest.seconds, each.args[2]) for each in said]  # type: ignore[union-attr]
        talk.on_backoff_over()
    assert len(told) == 1 and words in told[0][1]
    assert told[0][0] == min(seconds for seconds in rests if seconds >= REPORTED_BACKOFF)


def test_one_who_sends_back_our_header_is_refused() -> None:
    talk = make()
    talk.on_publisher_listed()
    talk.on_topic_response([1, "", ["TCPROS", "talker", 5000]])
    talk.on_connected(SENT)
    told, dropped = talk.on_received(encode_header(SENT))
    assert isinstance(told, do.LogMessage) and "only sends back what it receives" in told.args[0]
    assert dropped == do.EndAttempt()
    assert talk.state is State.REFUSED


@pytest.mark.parametrize("answer", [{"error": "no"}, {"md5sum": "x"}, {"type": "a/B"}])
def test_a_refusal_is_told_once_until_the_master_announces(answer: dict[str, str]) -> None:
    talk = make()
    for _ in range(2):
        talk.on_publisher_listed()
        talk.on_topic_response([1, "", ["TCPROS", "talker", 5000]])
        talk.on_connected(SENT)
        told, dropped = talk.on_received(encode_header(answer))
        assert isinstance(told, do.LogMessage) and told.is_error and dropped == do.EndAttempt()
        assert talk.state is State.REFUSED


def test_t15_a_publisher_of_another_type_is_linked_with_a_warning() -> None:
    talk = make()
    talk.on_publisher_listed()
    talk.on_topic_response([1, "", ["TCPROS", "talker", 5000]])
    talk.on_connected(SENT)
    told, linked = talk.on_received(encode_header({**GOOD, "md5sum": "x", "type": "a/B"}))
    assert isinstance(told, do.LogMessage) and not told.is_error and "as a/B [x]" in told.args[0]
    assert isinstance(linked, do.Link)


@pytest.mark.parametrize("data", [b"\xff\xff\xff\xff", b"\x04\0\0\0\xff\0\0\0", b"\x05\0\0\0\x01\0\0\0x"])
def test_a_broken_header_is_told_with_publisher_and_topic(data: bytes) -> None:
    talk = make()
    talk.on_publisher_listed()
    talk.on_topic_response([1, "", ["TCPROS", "talker", 5000]])
    talk.on_connected(SENT)
    told, dropped = talk.on_received(data)
    assert isinstance(told, do.LogMessage) and dropped == do.EndAttempt()
    assert told.args[0].startswith(f"publisher {URI} of /t: connection header")


class Dialogues(RuleBasedStateMachine):
    """Events in any order that a driver may bring them, with the invariants that no order may break."""

    def __init__(self) -> None:
        super().__init__()
        self.talk = make()
        self.resting = False  # a rest is to be reported
        self.watching = False  # silence is to be reported
        self.stopped = False
        self.forgotten = True
        self.silences = 0

    def take(self, actions: list[do.Action]) -> None:
        for action in actions:
            match action:
                case do.EndAttempt():
                    self.resting = self.watching = False
                case do.Backoff(seconds):
                    assert MIN_BACKOFF <= seconds <= MAX_BACKOFF and not self.resting
                    self.resting = True
                case do.RequestTopic(report_silence):
                    assert not self.watching
                    self.watching = report_silence
                case do.Link() | do.LinkDatagrams():
                    self.watching = False
                    assert self.talk.state is State.LINKED
                case do.Forget():
                    self.forgotten = True
                case do.LogMessage(False, text, args):
                    assert args[:2] == ("/t", URI) and text.count("%s") == len(args)

    def announce(self) -> None:
        self.forgotten = False
        busy = self.talk.state in IN_PROGRESS or self.talk.state is State.LINKED
        actions = self.talk.on_publisher_listed()
        assert bool(actions) != busy
        self.take(actions)

    @precondition(lambda self: not self.stopped)
    @rule()
    def publisher_listed(self) -> None:
        self.silences = 0 if self.talk.state not in IN_PROGRESS else self.silences
        self.announce()

    @precondition(lambda self: not self.stopped)
    @rule()
    def publisher_unlisted(self) -> None:
        self.take(self.talk.on_publisher_unlisted())

    @rule()
    def stop(self) -> None:
        self.stopped = True
        self.take(self.talk.stop())

    @precondition(lambda self: self.resting)
    @rule()
    def backoff_over(self) -> None:
        self.resting = False
        self.take(self.talk.on_backoff_over())
        assert self.talk.state is State.REQUESTING

    @precondition(lambda self: self.watching)
    @rule()
    def publisher_silent(self) -> None:
        self.watching = False
        self.silences += 1
        assert self.silences == 1, "named once, until there is a link or news"
        self.take(self.talk.on_publisher_silent())

    @precondition(lambda self: self.talk.state is State.REQUESTING)
    @rule(
        answer=st.sampled_from(
            [
                [1, "", ["TCPROS", "talker", 5000]],
                [1, "", ["TCPROS", "talker", 0]],
                [1, "", ["UDPROS", "talker", 6000, 7, 1500, encode_header(GOOD)[4:]]],
                [1, "", ["UDPROS", "talker", 6000, 7, 1500, b"\1"]],
                [0, "no", 0],
                [-1, "no publisher", []],
                None,
                [],
            ]
        ),
        datagrams_offered=st.booleans(),
    )
    def topic_answered(self, answer: Any, datagrams_offered: bool) -> None:
        self.take(self.talk.on_topic_response(answer, datagrams_offered=datagrams_offered))
        self.linked_now()

    @precondition(lambda self: self.talk.state is State.REQUESTING)
    @rule(publisher_refused=st.booleans())
    def in_this_process(self, publisher_refused: bool) -> None:
        self.take(self.talk.on_publisher_refused("another type") if publisher_refused else self.talk.on_linked())
        self.watching = False
        self.linked_now()

    @precondition(lambda self: self.talk.state is State.CONNECTING)
    @rule()
    def connected(self) -> None:
        self.take(self.talk.on_connected(SENT))

    @precondition(lambda self: self.talk.state is State.HANDSHAKE)
    @rule(data=st.sampled_from([encode_header(GOOD), encode_header({"error": "no"}), b"", b"\x10\0", b"\xff" * 8]))
    def received(self, data: bytes) -> None:
        self.take(self.talk.on_received(data))
        self.linked_now()

    @precondition(lambda self: self.talk.state in IN_PROGRESS)
    @rule(
        error=st.sampled_from([None, OSError("unreachable"), ProtocolError("odd"), UnknownHostError("nowhere", None)])
    )
    def attempt_failed(self, error: Exception | None) -> None:
        self.take(self.talk.on_attempt_failed(error))

    @precondition(lambda self: self.talk.state is State.LINKED)
    @rule(reason=st.sampled_from([None, "reset"]))
    def link_lost(self, reason: str | None) -> None:
        self.take(self.talk.on_link_lost(reason))

    def linked_now(self) -> None:
        if self.talk.state is State.LINKED:
            self.silences = 0

    @invariant()
    def never_deaf(self) -> None:
        """A publisher that is listed is linked, or will be tried, unless it has refused."""
        if self.talk.is_listed:
            assert self.talk.state in {State.LINKED, State.REFUSED, *IN_PROGRESS} or self.resting

    @invariant()
    def never_busy_for_nobody(self) -> None:
        """One that is not listed is not waited for, and forgotten once nothing is linked or under way."""
        if not self.talk.is_listed:
            assert not self.resting
            assert self.talk.state in {State.LINKED, State.GONE, *IN_PROGRESS}
            assert self.stopped or self.forgotten or self.talk.state is not State.GONE


Dialogues.TestCase.settings = settings(max_examples=200, stateful_step_count=40, deadline=None)
TestDialogues = Dialogues.TestCase
