"""Who handles packets: never two threads at a time, in order, and nobody waits for long."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from pyros1.bridge.clock import steady_now
from pyros1.bridge.packet_worker import PacketWorker
from pyros1.bridge.protocol.key_expressions import ROOT, Key, parse_key
from pyros1.bridge.protocol.packet_values import MAX_BODY
from pyros1.bridge.transport.inbox import Received

from .conftest import wait_until

PATIENCE = 10.0
WORKER = "bridge: packets"


def key(text: str) -> Key:
    found = parse_key(f"{ROOT}/{text}")
    assert found is not None
    return found


TOPIC, CONTROL = key("red/t/red/a"), key("red/to/base")


class Machine:
    """What a worker calls.

    Attributes:
        lock: its lock.
        handled: bodies of packets, each with the name of the thread that handled it.
        on_packet: what else to do about a packet.
    """

    def __init__(self) -> None:
        self.lock = threading.RLock()
        self.handled: queue.Queue[tuple[bytes, str]] = queue.Queue()
        self.ticks: queue.Queue[float] = queue.Queue()
        self.errors: queue.Queue[str] = queue.Queue()
        self.on_packet: Callable[[bytes], Any] = lambda _: None
        self.on_tick: Callable[[], Any] = lambda: None
        self.worker = PacketWorker(
            self.lock, steady_now, self._handle, self._tick, lambda error: self.errors.put(str(error))
        )

    def _handle(self, packet: Received, now: float) -> None:
        assert steady_now() - now < PATIENCE
        self.on_packet(packet[2])
        self.handled.put((packet[2], threading.current_thread().name))

    def _tick(self, now: float) -> None:
        self.ticks.put(now)
        self.on_tick()

    def receive(self, body: bytes, on: Key = TOPIC) -> None:
        """Receive a packet."""
        self.worker.receive(on, b"head", body)

    def next(self) -> tuple[bytes, str]:
        """Return the packet that is handled next, and by which thread."""
        return self.handled.get(timeout=PATIENCE)


@pytest.fixture
def machine() -> Iterator[Machine]:
    machine = Machine()
    yield machine
    machine.worker.close()


def test_where_nothing_waits_the_thread_that_brings_a_packet_handles_it(machine: Machine) -> None:
    own = threading.current_thread().name
    machine.receive(b"early")
    assert machine.handled.empty()
    machine.worker.start()
    assert machine.next() == (b"early", WORKER)
    handler = WORKER
    for _ in range(1000):  # the worker may still be busy with the first one
        machine.receive(b"x")
        handler = machine.next()[1]
        if handler == own:
            break
    assert handler == own


def test_the_thread_handles_what_takes_long(machine: Machine) -> None:
    """Meanwhile, what other sites send need not wait in the link, where nobody gets a turn."""
    machine.worker.start()
    machine.ticks.get(timeout=PATIENCE)  # the worker waits
    for _ in range(3):
        for size, on in ((60_000, CONTROL), (MAX_BODY - len(b"head"), CONTROL), (2_000_000, TOPIC)):
            machine.receive(bytes(size), on)
            body, handler = machine.next()
            assert len(body) == size and handler == WORKER
    machine.receive(bytes(MAX_BODY), CONTROL)
    assert machine.worker.inbox.dropped == 1 and machine.handled.empty()


@pytest.mark.parametrize(("size", "on"), [(40_000, CONTROL), (900_000, TOPIC)])
def test_the_thread_leaves_what_takes_little_to_the_link(machine: Machine, size: int, on: Key) -> None:
    machine.worker.start()
    handler = WORKER
    for _ in range(1000):
        machine.receive(bytes(size), on)
        handler = machine.next()[1]
        if handler != WORKER:
            break
    assert handler == threading.current_thread().name


def test_a_link_does_not_wait_for_the_lock(machine: Machine) -> None:
    machine.worker.start()
    machine.ticks.get(timeout=PATIENCE)
    with machine.lock:
        holder = threading.Thread(target=machine.receive, args=(b"first",))
        holder.start()
        holder.join(PATIENCE)
        assert not holder.is_alive() and machine.handled.empty()
        second = threading.Thread(target=machine.receive, args=(b"second",))
        second.start()
        second.join(PATIENCE)
    assert [machine.next(), machine.next()] == [(b"first", WORKER), (b"second", WORKER)]


def test_others_do_not_wait_for_a_packet_either(machine: Machine) -> None:
    machine.worker.start()
    machine.ticks.get(timeout=PATIENCE)
    begun, end = threading.Event(), threading.Event()

    def handle(body: bytes) -> None:
        if body == b"slow":
            begun.set()
            assert end.wait(PATIENCE)

    machine.on_packet = handle
    slow = threading.Thread(target=machine.receive, args=(b"slow",), name="slow")
    slow.start()
    assert begun.wait(PATIENCE)
    for number in range(3):
        machine.receive(b"%d" % number)
    end.set()
    assert machine.next()[0] == b"slow"
    assert [machine.next() for _ in range(3)] == [(b"%d" % number, WORKER) for number in range(3)]
    slow.join(PATIENCE)


def test_the_thread_takes_no_packet_while_another_one_is_handled(machine: Machine) -> None:
    """It would have to hold it back, and a later one could overtake it."""
    begun, end = threading.Event(), threading.Event()

    def handle(body: bytes) -> None:
        begun.set()
        assert end.wait(PATIENCE)

    machine.on_packet = handle
    machine.worker.start()
    machine.ticks.get(timeout=PATIENCE)
    slow = threading.Thread(target=machine.receive, args=(b"slow",))
    slow.start()
    assert begun.wait(PATIENCE)
    machine.receive(b"next")
    threading.Event().wait(0.3)  # a tick is due meanwhile
    assert not machine.worker.inbox.is_empty
    end.set()
    assert [machine.next()[0] for _ in range(2)] == [b"slow", b"next"]
    slow.join(PATIENCE)


def test_what_waits_is_handled_as_soon_as_nobody_is_busy(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.bridge.packet_worker.TICK", PATIENCE)
    begun, end = threading.Event(), threading.Event()

    def handle(body: bytes) -> None:
        begun.set()
        assert end.wait(PATIENCE)

    machine.on_packet = handle
    machine.worker.start()
    machine.ticks.get(timeout=PATIENCE)
    threading.Event().wait(0.1)  # it waits for the next tick
    slow = threading.Thread(target=machine.receive, args=(b"slow",))
    slow.start()
    assert begun.wait(PATIENCE)
    machine.receive(b"next")
    end.set()
    start = steady_now()
    assert [machine.next()[0] for _ in range(2)] == [b"slow", b"next"]
    assert steady_now() - start < PATIENCE / 2
    slow.join(PATIENCE)


def test_nothing_overtakes_what_waits_or_what_the_thread_has_taken(machine: Machine) -> None:
    machine.worker.start()
    machine.ticks.get(timeout=PATIENCE)
    machine.worker.inbox.put((TOPIC, b"head", b"first"))
    machine.receive(b"second")
    assert [machine.next()[0] for _ in range(2)] == [b"first", b"second"]
    with machine.lock:
        link = threading.Thread(target=machine.receive, args=(b"third",))
        link.start()
        link.join(PATIENCE)
        wait_until(lambda: machine.worker.inbox.is_empty, "the thread has taken it")
        machine.receive(b"fourth")
        assert machine.handled.empty()
    assert [machine.next()[0] for _ in range(2)] == [b"third", b"fourth"]


def test_errors_stop_neither_packets_nor_ticks(machine: Machine) -> None:
    def fail(*_: Any) -> None:
        raise ValueError("a mistake")

    machine.on_tick = fail
    machine.on_packet = fail
    machine.worker.start()
    machine.receive(b"x")
    for _ in range(2):
        machine.ticks.get(timeout=PATIENCE)
    assert {machine.errors.get(timeout=PATIENCE) for _ in range(3)} == {"a mistake"}
    machine.on_packet = lambda _: None
    machine.receive(b"y")
    assert machine.next()[0] == b"y"


def test_after_the_end_nothing_is_handled(machine: Machine) -> None:
    machine.worker.start()
    machine.worker.close()
    machine.receive(b"late")
    assert machine.handled.empty() and not machine.worker.inbox.is_empty


def test_in_a_flood_the_thread_handles_packets(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the link, where packets wait for those before them, sites do not take turns."""
    monkeypatch.setattr("pyros1.bridge.packet_worker.TICK", 1.0)  # a tick may take over
    own = threading.current_thread().name
    machine.worker.start()
    machine.ticks.get(timeout=PATIENCE)
    machine.on_packet = lambda _: threading.Event().wait(0.02)
    for number in range(40):
        machine.receive(b"%d" % number)
    handled = [machine.next() for _ in range(40)]
    assert [body for body, _ in handled] == [b"%d" % number for number in range(40)]
    assert [handler for _, handler in handled].count(own) < 10
    machine.on_packet = lambda _: None

    def is_over() -> bool:
        machine.receive(b"later")
        return machine.next()[1] == own

    wait_until(is_over, "the flood is over")


@pytest.mark.parametrize("brings_link", [True, False])
def test_close_waits_for_the_packet_that_is_handled(machine: Machine, brings_link: bool) -> None:
    """What it uses is closed afterwards."""
    begun, end = threading.Event(), threading.Event()

    def handle(body: bytes) -> None:
        begun.set()
        assert end.wait(PATIENCE)

    machine.on_packet = handle
    if not brings_link:
        machine.receive(b"early")
    machine.worker.start()
    machine.ticks.get(timeout=PATIENCE) if brings_link else begun.wait(PATIENCE)
    link = threading.Thread(target=machine.receive, args=(b"slow",), name="link")
    link.start()
    assert begun.wait(PATIENCE)
    start = steady_now()
    closer = threading.Thread(target=machine.worker.close)
    closer.start()
    closer.join(0.3)
    assert closer.is_alive() and machine.handled.empty()
    end.set()
    closer.join(PATIENCE)
    assert not closer.is_alive() and steady_now() - start < 2.0
    assert machine.next()[1] == ("link" if brings_link else WORKER)
    link.join(PATIENCE)


def test_time_does_not_go_back(machine: Machine) -> None:
    """A tick that had to wait for the lock gets the time at which it begins."""
    machine.worker.start()
    machine.ticks.get(timeout=PATIENCE)
    with machine.lock:
        threading.Event().wait(0.3)
        while not machine.ticks.empty():
            machine.ticks.get()
        end = steady_now()
    assert machine.ticks.get(timeout=PATIENCE) >= end


def test_many_threads(machine: Machine) -> None:
    """Each thread's packets are handled in order, all of them, and never two at the same time."""
    busy: list[bytes] = []

    def handle(body: bytes) -> None:
        busy.append(body)
        assert len(busy) == 1
        busy.clear()

    def bring(name: int) -> None:
        for number in range(300):
            machine.receive(b"%d %d" % (name, number))

    machine.on_packet = handle
    machine.worker.start()
    threads = [threading.Thread(target=bring, args=(name,)) for name in range(6)]
    for thread in threads:
        thread.start()
    handled = [machine.next()[0] for _ in range(6 * 300)]
    for thread in threads:
        thread.join()
    assert machine.errors.empty()
    for name in range(6):
        assert [body for body in handled if body.startswith(b"%d " % name)] == [
            b"%d %d" % (name, number) for number in range(300)
        ]
