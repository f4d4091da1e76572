"""delivery_loop: fresh data for slow callbacks, nothing lost without a bound, and peers that send nonsense.

Feature: a slow callback gets fresh messages -- as many as `queue_size`
"""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.msgs.std_msgs.msg import Float64, String
from pyros1.node.subscribing.delivery_loop import MAX_BATCH, MAX_CALLBACK_TIME, MAX_TURN_TIME, DeliveryLoop
from pyros1.node.subscribing.queues import Frames, Inbox
from pyros1.node.subscribing.tcp_source import TcpSource
from pyros1.wire.framing import MAX_MESSAGE_SIZE
from pyros1.wire.header import encode_header

from ...bodies import encode_frame
from ...parts import context_of, subscription_of


def frame(number: float) -> bytes:
    return encode_frame(Float64(number))


class Gate:
    """A callback that lets each message wait until the test says go."""

    def __init__(self) -> None:
        self.acquired: list[float] = []
        self.entered = threading.Semaphore(0)
        self.go = threading.Semaphore(0)

    def __call__(self, message: Any) -> None:
        self.acquired.append(message.data)
        self.entered.release()
        assert self.go.acquire(timeout=10)

    def open(self) -> None:
        self.go.release(10_000)


@pytest.fixture
def gate() -> Any:
    gate = Gate()
    yield gate
    gate.open()


# Slow callbacks -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("limit", [1, 5])
def test_a_slow_callback_gets_the_newest_messages(
    make_node: Any, transport: str, gate: Gate, collect: Any, limit: int
) -> None:
    talker, listener, probe = make_node("talker"), make_node("listener"), collect()
    subscriber = listener.subscribe("t", Float64, gate, queue_size=limit)
    make_node("probe").subscribe("t", Float64, probe)
    publisher = talker.advertise("t", Float64, queue_size=0)
    assert publisher.wait_for_subscribers(2, timeout=20)
    publisher.publish(0)
    assert gate.entered.acquire(timeout=20)
    for number in range(1, 1001):
        publisher.publish(number)
    probe.wait(1001)  # so they all have left the publisher
    gate.open()
    while gate.acquired[-1] != 1000:
        assert gate.entered.acquire(timeout=20)
    assert gate.acquired == [0, *range(1001 - limit, 1001)] or set(gate.acquired[-limit:]) <= set(
        range(1001 - limit, 1001)
    )
    assert len(gate.acquired) + subscriber.dropped == 1001


def test_without_a_bound_nothing_is_dropped(make_node: Any, transport: str, gate: Gate) -> None:
    talker, listener = make_node("talker"), make_node("listener")
    subscriber = listener.subscribe("t", Float64, gate)
    publisher = talker.advertise("t", Float64, queue_size=0)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(0)
    assert gate.entered.acquire(timeout=20)
    for number in range(1, 5001):
        publisher.publish(number)
    gate.open()
    for _ in range(5000):
        assert gate.entered.acquire(timeout=20)
    assert gate.acquired == list(range(5001))
    assert subscriber.dropped == 0


def test_callbacks_that_keep_up_lose_nothing_with_a_small_queue(
    make_node: Any, transport: str, collect: Any, fake_node: Any
) -> None:
    fake, acquired = fake_node("/fake"), collect()
    fake.publish("/t")
    make_node("listener").subscribe("t", Float64, acquired, queue_size=1)
    sock = fake.accept_subscriber()
    for number in range(200):
        sock.sendall(frame(number))
        acquired.wait(number + 1)
    assert acquired.data == list(range(200))


def test_a_publisher_without_queue_waits_for_a_slow_subscriber_in_the_process(
    make_node: Any, gate: Gate, in_thread: Any
) -> None:
    talker, listener = make_node("talker"), make_node("listener")
    listener.subscribe("t", Float64, gate)
    publisher = talker.advertise("t", Float64, queue_size=None)
    assert publisher.wait_for_subscribers(timeout=20)
    count = 3000
    publishing = in_thread(lambda: [publisher.publish(number) for number in range(count)])
    assert gate.entered.acquire(timeout=20)
    assert publishing.thread.is_alive() and subscription_of(listener).delivery.waiting <= 1000
    gate.open()
    publishing.join()
    while gate.acquired[-1] != count - 1:
        assert gate.entered.acquire(timeout=20)
    assert gate.acquired == list(range(count))


def test_the_publishers_queue_bounds_what_waits_within_the_process(make_node: Any, gate: Gate) -> None:
    talker, listener = make_node("talker"), make_node("listener")
    subscriber = listener.subscribe("t", Float64, gate)
    publisher = talker.advertise("t", Float64, queue_size=10)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(0)
    assert gate.entered.acquire(timeout=20)
    for number in range(1, 1001):
        publisher.publish(number)
    gate.open()
    while gate.acquired[-1] != 1000:
        assert gate.entered.acquire(timeout=20)
    assert gate.acquired == [0, *range(991, 1001)]
    assert subscriber.dropped == 990


@pytest.mark.parametrize(("size", "maximum"), [(10, 100), (100_000, 20), (2_000_000, 4)])
@pytest.mark.parametrize("latch", [False, True])
def test_within_the_process_room_may_be_left_as_in_sockets(
    make_node: Any, gate: Gate, size: int, maximum: int, latch: bool
) -> None:
    """Seen in programs for rospy: a burst of goals to an action server in the same process did not arrive."""
    node = make_node("node", local_room=1 << 20)
    node.subscribe("t", String, gate)
    publisher = node.advertise("t", String, queue_size=1, latch=latch)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish("begin")
    assert gate.entered.acquire(timeout=20)
    texts = [f"{number}".ljust(size) for number in range(100)]
    for text in texts:
        publisher.publish(text)
    gate.open()
    while gate.acquired[-1] != texts[-1]:
        assert gate.entered.acquire(timeout=20)
    assert gate.acquired[1:] == texts if maximum == 100 else len(gate.acquired[1:]) <= maximum


def test_callbacks_of_different_topics_do_not_wait_for_each_other(
    make_node: Any, transport: str, gate: Gate, collect: Any
) -> None:
    talker, listener, acquired = make_node("talker"), make_node("listener"), collect()
    listener.subscribe("slow", Float64, gate)
    listener.subscribe("quick", Float64, acquired)
    slow, quick = talker.advertise("slow", Float64), talker.advertise("quick", Float64)
    assert slow.wait_for_subscribers(timeout=20) and quick.wait_for_subscribers(timeout=20)
    slow.publish(1)
    assert gate.entered.acquire(timeout=20)
    quick.publish(2)
    acquired.wait()


def test_callbacks_of_one_topic_never_overlap(make_node: Any, transport: str) -> None:
    listener, inside, done = make_node("listener"), threading.Lock(), threading.Event()
    overlaps: list[float] = []
    count = iter(range(1, 401))

    def callback(message: Any) -> None:
        if not inside.acquire(blocking=False):
            overlaps.append(message.data)
        else:
            inside.release()
        if next(count) == 400:
            done.set()

    listener.subscribe("t", Float64, callback)
    publishers = [make_node(f"talker{index}").advertise("t", Float64, queue_size=0) for index in range(2)]
    for publisher in publishers:
        assert publisher.wait_for_subscribers(timeout=20)
    for number in range(200):
        for publisher in publishers:
            publisher.publish(number)
    assert done.wait(20)
    assert not overlaps


def test_a_link_that_comes_while_its_subscription_closes_does_not_hold_up_the_loop(
    make_node: Any, gate: Gate, until: Any
) -> None:
    """A callback that is running may take a long time."""
    talker, listener = make_node("talker"), make_node("listener")
    listener.subscribe("t", Float64, gate)
    publisher = talker.advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(1)
    assert gate.entered.acquire(timeout=10)
    delivery = subscription_of(listener).delivery
    ours, theirs = socket.socketpair()
    with theirs:
        delivery.stop()  # as another thread does, after the loop has checked whether the subscription is closed
        context_of(listener).loop.run(delivery.add, TcpSource(ours, "http://x:1/", {}, b""), timeout=2)
        gate.open()
        until(lambda: ours.fileno() < 0)


# Errors ---------------------------------------------------------------------------------------------------------------


def test_a_bad_callback_is_logged_and_called_again_t41(
    make_node: Any, transport: str, watch_log: Any, collect: Any
) -> None:
    talker, listener, other = make_node("talker"), make_node("listener"), collect()
    log = watch_log(listener)

    def bad(message: Any) -> None:
        raise RuntimeError(f"no {message.data:g}")

    listener.subscribe("t", Float64, bad)
    listener.subscribe("t", Float64, other)
    publisher = talker.advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(1)
    publisher.publish(2)
    text = log.saw("bad callback: ", " of /t", "RuntimeError: no 1")
    assert "Traceback" in text and "in bad" in text
    log.saw("RuntimeError: no 2")
    other.wait(2)
    assert other.data == [1, 2]


def test_a_malformed_message_is_logged_and_dropped_while_the_link_lives(
    make_node: Any, fake_node: Any, watch_log: Any, collect: Any
) -> None:
    fake, listener, acquired = fake_node("/fake"), make_node("listener"), collect()
    log = watch_log(listener)
    fake.publish("/t")
    subscriber = listener.subscribe("t", Float64, acquired)
    sock = fake.accept_subscriber()
    sock.sendall(frame(1) + b"\x03\0\0\0abc" + b"\x07\0\0\0" + bytes(7) + b"\0\0\0\0" + frame(2))
    acquired.wait(2)
    assert acquired.data == [1, 2]
    text = log.saw("/t from /fake", "std_msgs/Float64", "dropped")
    assert "byte" in text
    assert subscriber.num_connections == 1


def test_bad_utf8_in_a_string_costs_one_message(make_node: Any, fake_node: Any, watch_log: Any, collect: Any) -> None:
    fake, listener, acquired = fake_node("/fake"), make_node("listener"), collect()
    log = watch_log(listener)
    fake.publish("/t", "std_msgs/String")
    listener.subscribe("t", String, acquired)
    sock = fake.accept_subscriber(type="std_msgs/String", md5sum=String._md5sum)
    sock.sendall(b"\x06\0\0\0\x02\0\0\0\xff\xfe" + encode_frame(String("ä")))
    acquired.wait()
    assert acquired.data == ["ä"]
    log.saw("std_msgs/String", "dropped")


def test_a_publisher_that_closes_in_the_middle_of_a_message(make_node: Any, fake_node: Any, collect: Any) -> None:
    fake, listener, acquired = fake_node("/fake"), make_node("listener"), collect()
    fake.publish("/t")
    listener.subscribe("t", Float64, acquired)
    sock = fake.accept_subscriber()
    sock.sendall(frame(1) + frame(2)[:7])
    sock.close()
    sock = fake.accept_subscriber()  # it comes again, because the master still lists the publisher
    sock.sendall(frame(3))
    acquired.wait(2)
    assert acquired.data == [1, 3]


@pytest.mark.parametrize("size", [MAX_MESSAGE_SIZE + 1, 0xFFFFFFFF])
def test_a_hostile_length_ends_the_link_and_costs_no_memory_t02(
    make_node: Any, fake_node: Any, watch_log: Any, collect: Any, size: int
) -> None:
    fake, listener, acquired = fake_node("/fake"), make_node("listener"), collect()
    log = watch_log(listener)
    fake.publish("/t")
    listener.subscribe("t", Float64, acquired)
    sock = fake.accept_subscriber()
    sock.sendall(frame(1))
    acquired.wait()
    sock.sendall(size.to_bytes(4, "little") + b"xx")
    log.saw("/t", f"{size} bytes", "limit")
    sock = fake.accept_subscriber()
    sock.sendall(frame(2))
    acquired.wait(2)
    assert acquired.data == [1, 2]


def test_a_large_promise_without_bytes_costs_no_memory(make_node: Any, fake_node: Any, collect: Any) -> None:
    fake, listener, acquired = fake_node("/fake"), make_node("listener"), collect()
    fake.publish("/t")
    listener.subscribe("t", Float64, acquired)
    sock = fake.accept_subscriber()
    sock.sendall(frame(1) + MAX_MESSAGE_SIZE.to_bytes(4, "little") + b"xx")
    acquired.wait()
    (link,) = subscription_of(listener).links
    assert len(link.buffer.data) < 64 << 20


def test_frames_that_come_with_the_header_or_byte_by_byte(make_node: Any, fake_node: Any, collect: Any) -> None:
    fake, listener, acquired = fake_node("/fake"), make_node("listener"), collect()
    fake.publish("/t")
    listener.subscribe("t", Float64, acquired)
    sock, header = fake.accept()
    answer = encode_header({"type": "std_msgs/Float64", "md5sum": header["md5sum"], "callerid": "/fake"})
    sock.sendall(answer + frame(1) + frame(2)[:5])
    acquired.wait(1)
    sock.setsockopt(6, 1, 1)
    for byte in frame(2)[5:] + frame(3):
        sock.sendall(bytes([byte]))
    acquired.wait(3)
    assert acquired.data == [1, 2, 3]


def test_slow_callbacks_of_several_new_links_are_no_trouble(
    make_node: Any, fake_node: Any, collect: Any, watch_log: Any
) -> None:
    listener, acquired = make_node("listener"), collect()
    log = watch_log(listener)
    fakes = [fake_node(f"/fake{number}") for number in range(3)]
    for fake in fakes:
        fake.publish("/t")

    def slow(message: Any) -> None:
        threading.Event().wait(5 * MAX_CALLBACK_TIME)
        acquired(message)

    listener.subscribe("t", Float64, slow, queue_size=1)
    delivery, links = subscription_of(listener).delivery, collect()
    held, handle = threading.Event(), threading.Event()
    add = delivery.add

    def add_and_tell(link: Any) -> None:
        add(link)
        links(link)

    delivery.add = add_and_tell

    def hold() -> None:
        held.set()
        handle.wait(10)

    delivery.submit(hold)
    assert held.wait(20)
    for number, fake in enumerate(fakes):
        sock, header = fake.accept()
        answer = {"type": "std_msgs/Float64", "md5sum": header["md5sum"], "callerid": fake.name}
        sock.sendall(encode_header(answer) + frame(number))
    links.wait(3)
    handle.set()
    acquired.wait(3)
    assert sorted(acquired.data) == [0, 1, 2]
    listener.shutdown()
    assert not [text for text in log.texts if "internal error" in text]


# Nodes that spin ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("queue_size", "kept"), [(1, 1), (7, 7), (None, 1000)])
def test_a_node_that_spins_keeps_the_newest(
    make_node: Any, transport: str, collect: Any, until: Any, queue_size: int | None, kept: int
) -> None:
    talker, listener, acquired, probe = (
        make_node("talker"),
        make_node("listener", callbacks="spin"),
        collect(),
        collect(),
    )
    subscriber = listener.subscribe("t", Float64, acquired, queue_size=queue_size)
    make_node("probe").subscribe("t", Float64, probe)
    publisher = talker.advertise("t", Float64, queue_size=0)
    assert publisher.wait_for_subscribers(2, timeout=20)
    for number in range(1500):
        publisher.publish(number)
    probe.wait(1500)
    delivery = subscription_of(listener).delivery
    publisher.publish(1500)
    until(lambda: (delivery.waiting, subscriber.dropped) == (kept, 1501 - kept))
    assert not acquired.items, "no callback outside spin_once"
    listener.spin_once()
    while acquired.data[-1:] != [1500]:
        assert listener.spin_once(5.0)
    assert acquired.data[-kept:] == list(range(1501 - kept, 1501))
    assert len(acquired.items) + subscriber.dropped == 1501


def test_spin_once_runs_what_is_there_in_order_of_arrival(make_node: Any, transport: str) -> None:
    talker, listener = make_node("talker"), make_node("listener", callbacks="spin")
    acquired: list[Any] = []
    listener.subscribe("a", Float64, lambda m: acquired.append(("a", m.data, threading.current_thread())))
    listener.subscribe("b", Float64, lambda m: acquired.append(("b", m.data, threading.current_thread())))
    a, b = talker.advertise("a", Float64), talker.advertise("b", Float64)
    assert a.wait_for_subscribers(timeout=20) and b.wait_for_subscribers(timeout=20)
    for publisher, number in ((a, 1), (b, 2), (a, 3)):
        publisher.publish(number)
        assert context_of(listener).callback_queue.wait(5)
        while len(context_of(listener).callback_queue) < number:
            context_of(listener).callback_queue.wait(0.01)
    assert listener.spin_once() == 3
    assert [(topic, number) for topic, number, _ in acquired] == [("a", 1), ("b", 2), ("a", 3)]
    assert {thread for *_, thread in acquired} == {threading.current_thread()}
    assert listener.spin_once() == 0


def test_unregistered_callbacks_are_not_called_by_a_later_spin(make_node: Any, transport: str, collect: Any) -> None:
    talker, listener, acquired = make_node("talker"), make_node("listener", callbacks="spin"), collect()
    subscriber = listener.subscribe("t", Float64, acquired)
    publisher = talker.advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(1)
    assert context_of(listener).callback_queue.wait(5)
    subscriber.unregister()
    listener.spin_once()
    assert not acquired.items


# The end, while messages flow -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("callbacks", ["inline", "spin"])
@pytest.mark.parametrize("queue_size", [None, 1])
def test_unregistering_does_not_wait_for_a_pause_in_the_messages(
    make_node: Any, transport: str, in_thread: Any, until: Any, callbacks: str, queue_size: int | None
) -> None:
    talker, listener = make_node("talker"), make_node("listener", callbacks=callbacks)
    publisher = talker.advertise("t", Float64, queue_size=1)
    ended, flowing = threading.Event(), threading.Event()

    def talk() -> None:
        while not ended.wait(0.001):
            publisher.publish(1.0)

    in_thread(talk)
    try:
        subscriber = listener.subscribe("t", Float64, lambda _: flowing.set(), queue_size=queue_size)
        while not flowing.is_set():
            listener.spin_once(0.1)
        links = subscription_of(listener).links
        subscriber.unregister()
        assert links
        until(lambda: not any(link.connected for link in links))  # while the other one still talks
    finally:
        ended.set()


def test_unregistering_does_not_wait_for_a_callback(make_node: Any, transport: str, until: Any) -> None:
    """The caller may hold a lock for which the callback waits."""
    talker, listener = make_node("talker"), make_node("listener")
    publisher = talker.advertise("t", Float64)
    lock, inside, left = threading.Lock(), threading.Event(), threading.Event()

    def callback(_message: Any) -> None:
        inside.set()
        if lock.acquire(timeout=30):
            left.set()

    for _ in range(3):
        with lock:
            subscriber = listener.subscribe("t", Float64, callback)
            assert publisher.wait_for_subscribers(timeout=20)
            publisher.publish(1.0)
            assert inside.wait(5)
            links = subscription_of(listener).links
            subscriber.unregister()
            assert not left.is_set()
        assert left.wait(20)
        lock.release()
        until(lambda links=links: not any(link.connected for link in links) and not publisher.num_connections)
        inside.clear()
        left.clear()


def test_a_callback_waits_for_the_latched_message_of_its_own_topic(make_node: Any, transport: str) -> None:
    talker, listener = make_node("talker"), make_node("listener")
    talker.advertise("t", Float64, latch=True).publish(3.0)
    acquired: list[Any] = []
    done = threading.Event()

    def callback(_message: Any) -> None:
        if not done.is_set():
            acquired.append(listener.wait_for_message("t", Float64, timeout=10).data)
            listener.subscribe("t", Float64, lambda message: acquired.append(message.data + 1))
            done.set()

    listener.subscribe("t", Float64, callback)
    assert done.wait(15)
    assert acquired == [3.0, 4.0]


class _Driver:
    """Runs a delivery loop only when the test says so."""

    cooperative, has_waiting_thread = False, True

    def wake(self, _: Any) -> None: ...
    def register(self, fd: int, _: Any) -> None: ...
    def rearm(self, fd: int) -> None: ...
    def unregister(self, fd: int) -> None: ...


class _Here:
    """A source within the process."""

    header: dict[str, str] = {}
    connected = True


class _Dispatcher:
    """Gives each message to a function."""

    is_held_back = False

    def __init__(self, deliver: Callable[[Any], object]) -> None:
        self._deliver = deliver

    def deliver_frame(self, _: Any, data: bytes, start: int, end: int) -> None:
        self._deliver(data[start:end])

    def deliver_item(self, _: Any, item: Any) -> None:
        self._deliver(item)

    def forget(self, _: Any) -> None: ...


class _Link:
    """A TCP link whose messages came together with its header."""

    fd = 7

    can_wait = low_latency = False
    last_readable_at = 0.0

    def __init__(self, messages: list[bytes], *, later: list[bytes] | None = None) -> None:
        self._receives = [messages, later or []]

    def take_received(self, _: int) -> Frames:
        return self.receive()

    def receive(self, wait: bool = False) -> Frames:
        link: Any = self
        messages = self._receives.pop(0)
        frames = [(i, i + 4) for i in range(0, 4 * len(messages), 4)]
        return Frames(link, b"".join(messages), frames)

    def close(self) -> None: ...


def here() -> Inbox:
    """Return the inbox of a source within the process."""
    source: Any = _Here()
    return Inbox(source)


def loop_with(driver: Any, deliver: Callable[[Any], object]) -> Any:
    """Return a delivery loop that gives each message to a function."""
    dispatcher: Any = _Dispatcher(deliver)
    return DeliveryLoop(dispatcher, driver, None, lambda link, reason: None)


class Clock:
    """Stands in for `perf_counter`; counts how often it is read."""

    def __init__(self) -> None:
        self.now, self.readings = 1e5, 0

    def __call__(self) -> float:
        self.readings += 1
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr("pyros1.node.subscribing.delivery_loop.perf_counter", clock)
    return clock


@pytest.mark.parametrize("others", [False, True])
def test_the_turn_of_a_link_is_over_after_a_while_if_others_wait(clock: Clock, others: bool) -> None:
    said: list[object] = []
    inbox = here()

    def deliver(item: object) -> None:
        said.append(item)
        clock.now += 0.6 * MAX_TURN_TIME

    delivery = loop_with(_Driver(), deliver)
    messages = [b"%04d" % number for number in range(8)]
    delivery.add(_Link(messages))
    if others:
        delivery.inboxes.add(inbox)
        delivery.push(inbox, "other", 50)
    delivery.run(None)
    assert said == [*messages[:4], "other", *messages[4:]] if others else messages  # a turn of two, and another one


def test_a_link_delivers_what_it_has_before_it_receives_more(clock: Clock) -> None:
    said: list[object] = []

    def deliver(item: object) -> None:
        said.append(item)
        clock.now += 0.6 * MAX_TURN_TIME

    delivery = loop_with(_Driver(), deliver)
    messages = [b"%04d" % number for number in range(12)]
    link = _Link(messages[:8], later=messages[8:])
    delivery.add(link)
    delivery.run(link.fd)  # more has arrived when its first turn is over
    assert said == messages[:8]
    delivery.run(link.fd)
    assert said == messages


def test_nothing_is_delivered_after_the_end() -> None:
    said: list[object] = []

    def deliver(item: object) -> None:
        said.append(item)
        delivery.stop()

    delivery = loop_with(_Driver(), deliver)
    delivery.add(_Link([b"last", b"next", b"more"]))
    delivery.run(None)
    assert said == [b"last"]


def test_while_callbacks_are_fast_the_clock_is_read_once_for_many_messages(clock: Clock) -> None:
    said: list[object] = []
    delivery = loop_with(_Driver(), said.append)
    messages = [b"%04d" % number for number in range(1000)]
    delivery.add(_Link(messages))
    delivery.run(None)
    assert said == messages and clock.readings < 3 * len(messages) / MAX_BATCH


def test_who_subscribed_before_a_message_was_sent_gets_it_though_others_are_behind() -> None:
    """A job that begins a subscriber comes before the messages that were put after it."""
    said: list[object] = []
    inbox = here()

    def deliver(item: object) -> None:
        said.append(item)
        if item == "old":
            delivery.submit(lambda: said.append("begun"), by_callback=True)
            delivery.push(inbox, "new", 50)

    delivery = loop_with(_Driver(), deliver)
    delivery.inboxes.add(inbox)
    delivery.push(inbox, "old", 50)
    delivery.run(None)
    assert said == ["old", "begun", "new"]


def test_only_the_thread_of_an_asyncio_loop_does_the_jobs_of_its_deliveries() -> None:
    """They may move links from the loop to other threads, which a publisher's thread must not do."""
    said: list[object] = []
    driver = _Driver()
    delivery = loop_with(driver, said.append)
    delivery.in_publisher = driver.cooperative = True
    delivery.submit(lambda: said.append("moved"))
    assert not delivery.deliver_now(_Here(), "message")
    assert said == []
    delivery.run(None)
    assert delivery.deliver_now(_Here(), "message")
    assert said == ["moved", "message"]


def test_a_callback_that_raises_what_nobody_catches_costs_no_other_message() -> None:
    said: list[object] = []
    inbox = here()

    def deliver(item: object) -> None:
        said.append(item)
        if item == "bad":
            raise GeneratorExit

    delivery = loop_with(_Driver(), deliver)
    delivery.inboxes.add(inbox)
    for item in ("good", "bad", "next"):
        delivery.push(inbox, item, 50)
    with pytest.raises(GeneratorExit):
        delivery.run(None)
    delivery.run(None)
    assert said == ["good", "bad", "next"]


def test_a_full_inbox_is_emptied_in_place_of_a_busy_asyncio_loop() -> None:
    said: list[object] = []
    driver, inbox = _Driver(), here()
    driver.cooperative = True
    delivery = loop_with(driver, said.append)
    delivery.inboxes.add(inbox)
    for number in range(5):
        delivery.push(inbox, number, 2)
    assert said == [0, 1, 2, 3] and delivery.dropped == 0


def test_a_publisher_does_not_wait_for_a_busy_asyncio_loop() -> None:
    said: list[object] = []
    driver, inbox = _Driver(), here()
    driver.cooperative = True
    began, goes_on = threading.Event(), threading.Event()

    def deliver(item: object) -> None:
        said.append(item)
        began.set()
        assert goes_on.wait(15)

    delivery = loop_with(driver, deliver)
    delivery.inboxes.add(inbox)
    delivery.push(inbox, 0, 2)
    owner = threading.Thread(target=delivery.run, args=(None,))
    owner.start()
    assert began.wait(15)
    publisher = threading.Thread(target=lambda: [delivery.push(inbox, number, 2) for number in range(1, 5)])
    publisher.start()
    publisher.join(15)
    waits = publisher.is_alive()
    goes_on.set()
    publisher.join(15)
    owner.join(15)
    assert not waits and said[0] == 0 and delivery.dropped == 2


def test_a_wake_up_that_a_signal_handler_interrupted_is_repeated() -> None:
    woken: list[object] = []
    driver, inbox = _Driver(), here()

    def wake(loop: object) -> None:
        woken.append(loop)
        if len(woken) == 1:
            raise KeyboardInterrupt

    driver.wake = wake  # type: ignore[method-assign]
    delivery = loop_with(driver, lambda item: None)
    delivery.inboxes.add(inbox)
    with pytest.raises(KeyboardInterrupt):
        delivery.push(inbox, 1, 50)
    delivery.push(inbox, 2, 50)
    assert woken == [delivery, delivery]


@pytest.mark.parametrize("news", ["link", "message", "bytes", "job"])
def test_what_comes_while_a_publisher_delivers_wakes_a_thread(news: str) -> None:
    """Nobody is woken for it at once, since the publisher's thread owns the loop."""
    woken: list[object] = []
    driver, inbox, link = _Driver(), here(), _Link([b"last"])
    driver.wake = woken.append  # type: ignore[method-assign]

    def deliver(item: object) -> None:
        if item == "first":
            actions = {
                "link": lambda: delivery.add(link),
                "message": lambda: delivery.push(inbox, "last", 50),
                "bytes": lambda: delivery.run(link.fd),
                "job": lambda: delivery.submit(lambda: None),
            }
            actions[news]()
            assert not woken

    delivery = loop_with(driver, deliver)
    delivery.in_publisher = True
    delivery.inboxes.add(inbox)
    assert delivery.deliver_now(_Here(), "first")
    assert woken == [delivery]
