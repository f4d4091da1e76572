"""publication: new links and the end of a publication hold nobody up."""

from __future__ import annotations

import itertools
import socket
import sys
import threading
import time
from collections.abc import Callable
from math import inf
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.msgs.geometry_msgs.msg import Point, PointStamped
from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.node.publishing.local_link import UNBOUNDED_LIMIT
from pyros1.node.publishing.publication import Publication
from pyros1.node.publishing.tcp_link import TcpLink
from pyros1.node.strand import Strand
from pyros1.wire.handshake import Refusal, make_subscriber_header

from ...bodies import decode, encode
from ...parts import context_of, on_loop, publication_of

BIG = 20_000_000


def over_tcp(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.node.subscribing.connector.find_local_context", lambda uri: None)


def occupy(strand: Strand) -> None:
    """Take a strand, as if somebody worked there, once those who do have left."""
    for _ in range(5000):
        try:
            del strand.free[0]
            return
        except IndexError:
            time.sleep(0.001)  # it is not theirs to say that they leave
    raise AssertionError("the lane is never free")


def greet(peer: Any, type: Any, topic: str = "/t") -> Any:
    peer.greet(topic=topic, md5sum=type._md5sum, type=type._type, callerid="/raw")
    assert "error" not in peer.answer()
    return peer


@pytest.mark.slow
def test_a_latched_message_for_a_stuck_subscriber_does_not_stop_the_loop(
    make_node: Any, raw_peer: Any, in_thread: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    over_tcp(monkeypatch)
    talker = make_node("talker")
    publisher = talker.advertise("t", Image, queue_size=None, latch=True)
    publisher.publish(Image(height=1, data=bytes(BIG)))
    peer = greet(raw_peer(talker, receive_buffer=65536), Image)
    assert publisher.wait_for_subscribers(timeout=20)
    on_loop(talker)
    publishing = in_thread(publisher.publish, Image(height=2))  # waits for the latched one to go, and stays behind it
    heights = [decode(Image, body).height for body in (peer.frame(), peer.frame())]
    assert heights == [1, 2]
    publishing.join()


@pytest.mark.slow
def test_a_large_latched_message_reaches_who_comes_later_without_another_publish(
    make_node: Any, raw_peer: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    over_tcp(monkeypatch)
    talker = make_node("talker")
    publisher = talker.advertise("t", Image, queue_size=None, latch=True)
    publisher.publish(Image(height=1, data=bytes(BIG)))
    body = greet(raw_peer(talker, receive_buffer=65536), Image).frame()
    assert decode(Image, body).height == 1


def test_a_latched_message_does_not_wait_for_room_within_the_process(make_node: Any, in_thread: Any) -> None:
    talker, listener = make_node("talker"), make_node("listener")
    entered, go_on = threading.Event(), threading.Event()

    def stuck(_: Any) -> None:
        entered.set()
        go_on.wait(20)

    listener.subscribe("t", Float64, stuck)
    full = talker.advertise("t", Float64, queue_size=0)
    assert full.wait_for_subscribers(timeout=20)
    full.publish(0.0)
    assert entered.wait(20)
    for _ in range(2 * UNBOUNDED_LIMIT):
        full.publish(0.0)
    try:
        other = make_node("other").advertise("t", Float64, queue_size=None, latch=True)
        in_thread(other.publish, 1.0)
        assert other.wait_for_subscribers(timeout=20)
        on_loop(listener)
    finally:
        go_on.set()


def test_a_closed_publication_refuses_links(make_node: Any) -> None:
    talker, listener = make_node("talker"), make_node("listener")
    talker.advertise("t", Float64)
    publication = publication_of(talker)
    publication.close()
    listener.subscribe("t", Float64, print)
    on_loop(listener)
    header = make_subscriber_header("/late", "/t", publication.type, tcp_nodelay=False)
    near, far = socket.socketpair()
    with near, far, pytest.raises(Refusal, match="no longer a publisher"):
        publication.accept(near, header)
    assert publication.links == ()


@pytest.mark.parametrize("wanted", [0, 1])
def test_small_packets_are_sent_at_once_for_subscribers_that_want_it(make_node: Any, wanted: int) -> None:
    talker = make_node("talker")
    talker.advertise("t", Float64)
    publication = publication_of(talker)
    header = make_subscriber_header("/peer", "/t", publication.type, tcp_nodelay=bool(wanted))
    with socket.create_server(("127.0.0.1", 0)) as server, socket.create_connection(server.getsockname()):
        near, _ = server.accept()
        context_of(talker).loop.run(publication.accept, near, header)
        assert bool(near.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)) == bool(wanted)


def test_a_publication_that_its_own_work_closes_waits_for_nobody(
    make_node: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As when a signal handler interrupts a publish() and ends the node."""
    talker = make_node("talker")
    talker.advertise("t", Float64)
    publication = publication_of(talker)
    clock = SimpleNamespace(sleep=lambda seconds: pytest.fail(f"slept {seconds} s"))
    monkeypatch.setattr("pyros1.node.publishing.publication.time", clock)
    publication.strand.do(publication.close, inf)
    header = make_subscriber_header("/late", "/t", publication.type, tcp_nodelay=False)
    with socket.socket() as late, pytest.raises(Refusal, match="no longer a publisher"):
        publication.accept(late, header)


@pytest.mark.slow
def test_messages_that_are_queued_when_the_node_ends_are_sent(
    make_node: Any, raw_peer: Any, in_thread: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    over_tcp(monkeypatch)
    monkeypatch.setattr("pyros1.node.topics.CLOSE_TIMEOUT", 60.0)
    talker = make_node("talker")
    publisher = talker.advertise("t", Image, queue_size=10)
    peer = greet(raw_peer(talker, receive_buffer=65536), Image)
    assert publisher.wait_for_subscribers(timeout=20)
    for height in (1, 2):
        publisher.publish(Image(height=height, data=bytes(BIG)))
    assert publication_of(talker).links[0].waiting
    ending = in_thread(talker.shutdown)
    assert [decode(Image, peer.frame()).height for _ in range(2)] == [1, 2]
    ending.join()


def test_all_topics_of_a_node_end_by_one_deadline(make_node: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    talker = make_node("talker")
    for number in range(3):
        talker.advertise(f"t{number}", Float64)
    deadlines: list[Any] = []
    context, close = context_of(talker), Publication.close

    def watch(publication: Publication, until: float | None = None) -> None:
        deadlines.append(until)
        assert publication.topic not in context.publications
        close(publication, until)

    monkeypatch.setattr(Publication, "close", watch)
    talker.shutdown()
    assert len(deadlines) >= 3 and len(set(deadlines)) == 1 and deadlines[0] is not None


@pytest.mark.parametrize("cls", [Float64, Image])
def test_publishing_after_the_end_of_the_node_is_said_once(make_node: Any, capsys: Any, cls: Any) -> None:
    talker = make_node("talker")
    publisher = talker.advertise("t", cls)
    talker.shutdown()
    capsys.readouterr()
    for _ in range(3):
        publisher.publish(cls())
    said = capsys.readouterr()
    assert (said.out + said.err).count("publish() on /t after its node has shut down: the message is lost") == 1


def test_the_last_messages_for_a_stuck_subscriber_do_not_stop_the_loop(
    make_node: Any, raw_peer: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    over_tcp(monkeypatch)
    talker = make_node("talker")
    publisher = talker.advertise("t", Image, queue_size=10)
    greet(raw_peer(talker, receive_buffer=4096), Image)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(Image(data=bytes(BIG)))
    (link,), strand = publication_of(talker).links, publication_of(talker).strand
    locked: list[bool] = []

    def wait(_: Any) -> None:
        locked.append(strand.runs_in_this_thread)
        done = threading.Event()
        context_of(talker).loop.call_soon(strand.do, done.set)
        assert done.wait(20)
        link.close()

    monkeypatch.setattr("pyros1.node.publishing.tcp_link.wait_writable", wait)
    link.finish(inf)
    assert locked == [False] and not link.connected


@pytest.mark.parametrize("message_class", [Float64, Image])
def test_who_is_connected_and_who_comes_later_end_with_the_same_message(
    make_node: Any, transport: str, collect: Any, in_thread: Any, message_class: Any
) -> None:
    talker, early, late = make_node("talker"), collect(), collect()
    make_node("early").subscribe("t", message_class, early)
    publisher = talker.advertise("t", message_class, latch=True, queue_size=10)
    assert publisher.wait_for_subscribers(timeout=20)
    (link,) = publication_of(talker).links
    entered, second_is_out = threading.Event(), threading.Event()
    send = link.send

    def hold(frame: Any) -> None:
        if not entered.is_set():
            entered.set()
            second_is_out.wait(5)
        send(frame)

    link.send = hold
    messages = [message_class(1), message_class(2)] if message_class is Float64 else [Image(height=1), Image(height=2)]
    first = in_thread(publisher.publish, messages[0])
    assert entered.wait(20)
    publisher.publish(messages[1])  # while the first is on its way
    second_is_out.set()
    first.join()
    early.wait(2)
    make_node("late").subscribe("t", message_class, late)
    assert late.wait(1)[-1] == early.items[-1]
    if message_class is Image:
        assert [message.header.seq for message in early.items] == [1, 2]
        assert [message.height for message in early.items] == [1, 2]


@pytest.mark.parametrize("message_class", [Float64, Image])
def test_a_message_comes_after_all_that_its_thread_has_left_to_others(
    make_node: Any, raw_peer: Any, message_class: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.strand.MAX_JOBS_PER_TURN", turn := 8)
    talker = make_node("talker")
    publisher = talker.advertise("t", message_class, queue_size=0)
    peer = greet(raw_peer(talker), message_class)
    assert publisher.wait_for_subscribers(timeout=20)
    strand = publication_of(talker).strand
    count = 3 * turn
    field = "data" if message_class is Float64 else "height"
    occupy(strand)
    for number in range(count):
        publisher.publish(message_class(**{field: number}))
    strand.free.append(True)
    publisher.publish(message_class(**{field: count}))
    bodies = [peer.frame() for _ in range(count + 1)]
    messages = [decode(message_class, body) for body in bodies]
    assert [getattr(message, field) for message in messages] == list(range(count + 1))
    if message_class is Image:
        assert [message.header.seq for message in messages] == list(range(1, count + 2))


def test_a_publisher_without_a_queue_waits_for_a_message_that_it_left_to_another_thread(
    make_node: Any, raw_peer: Any, in_thread: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.publishing.publication.MAX_STRAND_WAIT", 60.0)
    talker = make_node("talker")
    publisher = talker.advertise("t", Float64, queue_size=None)
    peer = greet(raw_peer(talker), Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    strand = publication_of(talker).strand
    slept: list[float] = []

    def leave_strand(seconds: float) -> None:
        if not slept:
            strand.free.append(True)
        slept.append(seconds)

    clock = SimpleNamespace(sleep=leave_strand)
    monkeypatch.setattr("pyros1.node.publishing.publication.time", clock)
    occupy(strand)
    in_thread(publisher.publish, Float64(7)).join()
    if not slept:
        strand.free.append(True)
    assert slept and max(slept) < 0.01 and publication_of(talker).links[0].messages == 1
    assert decode(Float64, peer.frame()) == Float64(7)


def test_a_message_for_the_process_goes_to_who_has_taken_its_place_meanwhile(
    make_node: Any, raw_peer: Any, collect: Any
) -> None:
    talker = make_node("talker")
    publisher = talker.advertise("t", Float64, queue_size=10)
    subscriber = make_node("listener").subscribe("t", Float64, collect())
    assert publisher.wait_for_subscribers(timeout=20)
    publication = publication_of(talker)
    local, changed = publication.links[0], threading.Event()
    publication.change_listeners.append(lambda: local not in publication.links and publication.links and changed.set())
    peers: list[Any] = []

    class Number:
        """Takes long to become a float: when it has, another subscriber has come in place of the first."""

        def __float__(self) -> float:
            publication.strand.free.append(True)
            subscriber.unregister()
            peers.append(greet(raw_peer(talker), Float64))
            assert changed.wait(20)
            return 1.0

    occupy(publication.strand)  # so the message is left
    publisher.publish(Number())
    assert decode(Float64, peers[0].frame()) == Float64(1.0)


def test_a_message_for_the_process_goes_to_who_comes_before_its_turn(
    make_node: Any, raw_peer: Any, collect: Any, until: Any
) -> None:
    talker, got = make_node("talker"), collect()
    publisher = talker.advertise("t", Float64, queue_size=10)
    make_node("listener").subscribe("t", Float64, got)
    assert publisher.wait_for_subscribers(timeout=20)
    strand = publication_of(talker).strand
    occupy(strand)
    peer = raw_peer(talker).greet(topic="/t", md5sum="*", type="*", callerid="/raw")
    until(lambda: strand.jobs)  # the peer's link waits for its turn
    publisher.publish(1.0)
    strand.free.append(True)
    strand.work()
    assert "error" not in peer.answer() and peer.frame() == encode(Float64(1.0))
    assert got.wait(1)[0].data == 1.0


def test_sequence_numbers_begin_again(make_node: Any, collect: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.node.publishing.publication.NUM_SEQUENCE_NUMBERS", 3)
    got = collect()
    make_node("listener").subscribe("t", Image, lambda message: got(message.header.seq))
    publisher = make_node("talker").advertise("t", Image)
    assert publisher.wait_for_subscribers(timeout=20)
    for _ in range(6):
        publisher.publish(Image())
    assert got.wait(6) == [1, 2, 0, 1, 2, 0]


@pytest.mark.parametrize("queue_size", [None, 0])
def test_sequence_numbers_of_several_threads_run_forward(
    make_node: Any, transport: str, collect: Any, in_thread: Any, queue_size: int | None
) -> None:
    talker, got = make_node("talker"), collect()
    make_node("listener").subscribe("t", Image, lambda message: got(message.header.seq))
    publisher = talker.advertise("t", Image, queue_size=queue_size)
    assert publisher.wait_for_subscribers(timeout=20)

    def flood() -> None:
        for _ in range(500):
            publisher.publish(Image())

    for thread in [in_thread(flood) for _ in range(4)]:
        thread.join()
    got.wait(2000)
    assert got.items == list(range(1, 2001))


def test_whoever_has_the_greeting_gets_what_is_published_next(
    make_node: Any, raw_peer: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    over_tcp(monkeypatch)
    talker = make_node("talker")
    publisher = talker.advertise("t", Float64, queue_size=10)
    known: list[bool] = []
    start = TcpLink.start

    def note(link: TcpLink) -> None:
        known.append(link in publication_of(talker).links)
        start(link)

    monkeypatch.setattr(TcpLink, "start", note)
    peer = greet(raw_peer(talker), Float64)
    publisher.publish(1.0)
    assert peer.frame() == encode(Float64(1.0))
    assert known == [True], "before it is greeted"


class InterruptedAt:
    """Calls a handler at one of the moments where Python may run those of signals: a call, or the return of one.

    Args:
        moment: its number, from 0.
    """

    def __init__(self, moment: int, handler: Callable[[], object]) -> None:
        self._left = moment
        self._handler = handler
        self.where: str | None = None

    def __call__(self, frame: Any, event: str, what: Any) -> None:
        if event == "c_call" or self.where is not None or "/pyros1/" not in frame.f_code.co_filename:
            return
        self._left -= 1
        if self._left < 0:
            self.where = f"{frame.f_code.co_name}:{event}"
            self._handler()


@pytest.mark.parametrize("queue_size", [None, 0, 100])
@pytest.mark.parametrize("message_class", [Point, PointStamped])
def test_what_a_signal_handler_publishes_comes_after_what_it_has_interrupted(
    make_node: Any, collect: Any, transport: str, message_class: Any, queue_size: int | None
) -> None:
    """A robot that a handler stops must not be set going again by the publish() that was under way."""
    node, got = make_node("talker", rosout=False), collect()
    make_node("listener", rosout=False).subscribe("t", message_class, got)
    publisher = node.advertise("t", message_class, queue_size=queue_size)
    assert publisher.wait_for_subscribers(timeout=10)
    stop, going = message_class(), message_class()
    getattr(going, "point", going).x = 1.0
    ends: list[tuple[str, float]] = []
    for moment in itertools.count():
        interruption = InterruptedAt(moment, lambda: publisher.publish(stop))
        sys.setprofile(interruption)
        try:
            publisher.publish(going)
        finally:
            sys.setprofile(None)
        if interruption.where is None:
            break
        last = got.wait(2 * (moment + 1))[-1]
        ends.append((interruption.where, getattr(last, "point", last).x))
    got.wait(2 * moment + 1)
    # What comes before the message has its turn is like what comes before the call of publish().
    before = [where.partition(":")[0] for where, _ in itertools.takewhile(lambda end: end[1], ends)]
    assert set(before) <= {"publish", "_publish", "_publish_numbered"} and len(before) < len(ends) / 2, ends
    assert not any(x for _, x in ends[len(before) :]), ends
