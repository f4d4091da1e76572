"""The local transport between nodes: what comes, in which order, what may be kept, and how it ends.

Feature: between nodes on one machine, large messages go through shared memory, small ones and service calls over Unix
    sockets -- automatic; `PYROS1_TRANSPORTS=tcp` turns it off (`pyros1 guide howto performance`)
"""

from __future__ import annotations

import contextlib
import errno
import gc
import itertools
import os
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pyros1.ground.errors import SettingError
from pyros1.msgs import AnyMsg, record_dtype
from pyros1.msgs.geometry_msgs.msg import Pose, PoseArray
from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.msgs.std_msgs.msg import Float64, Float64MultiArray, UInt8MultiArray
from pyros1.node.same_host import host_key, listen
from pyros1.wire.header import encode_header

from ..bodies import encode
from ..parts import context_of

pytestmark = [
    pytest.mark.skipif(not host_key(), reason="no shared memory on this system"),
    pytest.mark.parametrize("transport", ["local"], indirect=True),
]
PATIENCE = 20.0
LARGE = 300_000
KILLS = int(os.environ.get("PYROS1_KILLS", "3"))
"""Programs that `test_killed` kills in each role; a number of hundreds is for a patient reader."""


@pytest.fixture
def linked(make_node: Any, collect: Any, transport: str) -> Iterator[Any]:
    """Return a function that makes a publisher, and a subscriber whose messages it collects."""
    numbers = itertools.count()

    def link(
        cls: Any = Image, queue_size: int | None = 10, callback: Any = None, latch: bool = False, **options: Any
    ) -> Any:
        topic, got = f"/t{next(numbers)}", callback or collect()
        publisher = make_node(f"talker{topic[1:]}").advertise(topic, cls, queue_size=queue_size, latch=latch)
        subscriber = make_node(f"listener{topic[1:]}").subscribe(topic, options.pop("as_", cls), got, **options)
        assert publisher.wait_for_subscribers(1, PATIENCE) and subscriber.wait_for_publishers(1, PATIENCE)
        assert [link.transport for link in subscriber.links] == ["LOCAL"]
        return publisher, subscriber, got

    yield link


def image(number: int, size: int = LARGE) -> Any:
    return Image(height=number, encoding="mono8", data=bytes([number % 256]) * size)


@pytest.mark.parametrize("arrays", [None, "memoryview", "numpy"])
def test_large_messages(linked: Any, arrays: str | None) -> None:
    publisher, _, got = linked(queue_size=0, arrays=arrays)
    for number in range(50):
        publisher.publish(image(number))
    for number, message in enumerate(got.wait(50)):
        assert message.height == number and message.encoding == "mono8"
        assert bytes(message.data) == bytes([number]) * LARGE
        assert (
            message._connection_header["callerid"].startswith("/talker") and "token" not in message._connection_header
        )


def test_messages_without_an_array_of_bytes(linked: Any) -> None:
    publisher, _, got = linked(Float64MultiArray, queue_size=0)
    for number in range(20):
        publisher.publish(Float64MultiArray(data=[float(number)] * 20_000))
    assert [message.data[-1] for message in got.wait(20)] == [float(number) for number in range(20)]


@pytest.mark.parametrize("count", [0, 3, 5000])
def test_messages_in_an_array_with_columns(linked: Any, count: int) -> None:
    publisher, _, got = linked(PoseArray, queue_size=0, arrays="numpy")
    sent = np.zeros(count, record_dtype(Pose))
    sent["position"]["x"] = np.arange(count)
    publisher.publish(PoseArray(poses=sent))
    publisher.publish(PoseArray(poses=[Pose() for _ in range(count)]))
    columns, zeros = [message.poses.position.x for message in got.wait(2)]
    assert columns.tolist() == list(range(count)) and not zeros.any() and len(zeros) == count


def test_undecoded_messages(linked: Any) -> None:
    publisher, _, got = linked(UInt8MultiArray, queue_size=0, as_=AnyMsg)
    message = UInt8MultiArray(data=os.urandom(LARGE))
    publisher.publish(message)
    assert bytes(got.wait()[0]._buff) == encode(message)


@pytest.mark.slow
@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    sizes=st.lists(st.sampled_from([0, 1, 1000, 65_000, 65_536, 70_000, 131_072, 500_000]), max_size=40),
    queue_size=st.sampled_from([None, 0]),
    arrays=st.sampled_from([None, "numpy"]),
)
def test_small_and_large_ones_come_in_order(linked: Any, sizes: list[int], queue_size: int | None, arrays: Any) -> None:
    publisher, _, got = linked(queue_size=queue_size, arrays=arrays)
    for number, size in enumerate(sizes):
        publisher.publish(image(number, size))
    received = [(message.height, len(message.data), set(bytes(message.data))) for message in got.wait(len(sizes))]
    assert received == [(number, size, {number} if size else set()) for number, size in enumerate(sizes)]


@pytest.mark.slow
def test_messages_that_are_kept_stay_as_they_are(linked: Any) -> None:
    publisher, subscriber, got = linked(queue_size=0, arrays="memoryview")
    for number in range(100):  # more than there are blocks
        publisher.publish(image(number))
    kept = got.wait(100)[:]
    subscriber.unregister()
    publisher.unregister()
    gc.collect()
    assert all(bytes(message.data) == bytes([number]) * LARGE for number, message in enumerate(kept))


def test_a_slow_callback_gets_the_newest(linked: Any, until: Any) -> None:
    go_on, numbers = threading.Event(), []

    def slow(message: Any) -> None:
        numbers.append(message.height)
        go_on.wait(PATIENCE)

    publisher, _, _ = linked(queue_size=2, callback=slow)
    publisher.publish(image(0))
    until(lambda: numbers)
    for number in range(1, 200):
        publisher.publish(image(number))
    go_on.set()
    until(lambda: numbers[-1] == 199)
    assert numbers == sorted(numbers) and len(numbers) < 30


def test_publishers_wait_for_subscribers_without_a_queue(linked: Any) -> None:
    """None is lost, and the publisher does not run ahead by more than the references that may be out."""
    ahead: list[int] = []
    published = itertools.count()
    last = 0

    def take(message: Any) -> None:
        nonlocal last
        ahead.append(last - message.height)
        got.append(message.height)

    got: list[int] = []
    publisher, _, _ = linked(queue_size=None, callback=take)
    for number in published:
        publisher.publish(image(number))
        last = number
        if number == 300:
            break
    publisher.unregister()
    assert got == [*range(301)][: len(got)] and len(got) > 280 and max(ahead) < 20


def test_late_subscribers_get_a_latched_one(linked: Any, make_node: Any, collect: Any) -> None:
    publisher, subscriber, got = linked(queue_size=0, latch=True, arrays="memoryview")
    for number in range(20):
        publisher.publish(image(number))
    got.wait(20)
    late = collect()
    make_node("late").subscribe(subscriber.name, Image, late)
    assert late.wait()[0].height == 19
    publisher.publish(image(20))
    assert late.wait(2)[1].height == 20


def test_nodes_that_spin(make_node: Any, collect: Any, transport: str, in_thread: Any) -> None:
    publisher = make_node("talker").advertise("/t", Image, queue_size=0)
    listener, got = make_node("listener", callbacks="spin"), collect()
    listener.subscribe("/t", Image, got, arrays="memoryview")
    assert publisher.wait_for_subscribers(1, PATIENCE)
    spinning = in_thread(listener.spin)
    for number in range(60):
        publisher.publish(image(number))
    assert [message.height for message in got.wait(60)] == [*range(60)]
    listener.shutdown()
    spinning.join()


def test_several_subscribers_share_what_is_written(make_node: Any, collect: Any, transport: str) -> None:
    publisher = make_node("talker").advertise("/t", Image, queue_size=0)
    received = [collect() for _ in range(4)]
    for number, got in enumerate(received):
        make_node(f"listener{number}").subscribe("/t", Image, got)
    assert publisher.wait_for_subscribers(4, PATIENCE)
    for number in range(40):
        publisher.publish(image(number))
    for got in received:
        assert [(message.height, message.data[0]) for message in got.wait(40)] == [(n, n) for n in range(40)]


@pytest.mark.slow
def test_subscribers_that_come_and_go(make_node: Any, collect: Any, transport: str) -> None:
    publisher = make_node("talker").advertise("/t", Image, queue_size=5)
    ended = threading.Event()

    def publish() -> None:
        for number in itertools.count():
            if ended.is_set():
                return
            publisher.publish(image(number))

    thread = threading.Thread(target=publish)
    thread.start()
    try:
        kept: list[Any] = []
        for number in range(12):
            got = collect()
            with make_node(f"listener{number}").subscribe("/t", Image, got, arrays="memoryview"):
                kept += got.wait(3)[:3]
        heights = [message.height for message in kept]
        assert all(set(bytes(message.data)) == {message.height % 256} for message in kept) and heights == sorted(
            heights
        )
    finally:
        ended.set()
        thread.join()


def test_a_socket_that_is_gone_leaves_tcp(
    make_node: Any, collect: Any, transport: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(name: str) -> socket.socket:
        raise ConnectionRefusedError(errno.ECONNREFUSED, "Connection refused")

    monkeypatch.setattr("pyros1.node.same_host.connect", refuse)
    publisher = make_node("talker").advertise("/t", Image, queue_size=5)
    got = collect()
    subscriber = make_node("listener").subscribe("/t", Image, got)
    assert publisher.wait_for_subscribers(1, PATIENCE) and subscriber.wait_for_publishers(1, PATIENCE)
    publisher.publish(image(3))
    assert got.wait()[0].height == 3 and [link.transport for link in subscriber.links] == ["TCPROS"]


def test_blocks_that_cannot_be_read_leave_tcp(linked: Any, watch_log: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """As when the subscriber has no descriptor left: it says so, and gets the next messages."""
    publisher, subscriber, got = linked()
    publisher.publish(image(0))
    got.wait()

    def without(sock: socket.socket, size: int, most: int, flags: int = 0) -> Any:
        data, descriptors, message_flags, address = received(sock, size, most, flags)
        if sock.type == socket.SOCK_SEQPACKET:
            for descriptor in descriptors:
                os.close(descriptor)
            descriptors = []
        return data, descriptors, message_flags, address

    received = socket.recv_fds
    monkeypatch.setattr(socket, "recv_fds", without)
    number = 1
    while [link.transport for link in subscriber.links] != ["TCPROS"]:
        publisher.publish(image(number, number * 10_000 + LARGE))
        number += 1
        assert number < 100_000
    publisher.publish(image(7, 10))
    assert got.until(lambda items: items[-1].height == 7)


def test_a_header_that_comes_without_its_descriptor_leaves_tcp(
    make_node: Any, collect: Any, transport: str, watch_log: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As when the subscriber has no descriptor left just then: references could not be followed."""

    def without(sock: socket.socket, size: int, most: int, flags: int = 0) -> Any:
        data, descriptors, message_flags, address = received(sock, size, most, flags)
        for descriptor in descriptors:
            os.close(descriptor)
        return data, [], message_flags, address

    received = socket.recv_fds
    monkeypatch.setattr(socket, "recv_fds", without)
    publisher = make_node("talker").advertise("/t", Image, queue_size=5)
    node, got = make_node("listener"), collect()
    log = watch_log(node)
    subscriber = node.subscribe("/t", Image, got)
    log.saw("lost the connection to the publisher of /t", "are too many files open?")
    assert subscriber.wait_for_publishers(1, PATIENCE) and publisher.wait_for_subscribers(1, PATIENCE)
    publisher.publish(image(3))
    assert got.wait()[0].height == 3 and [link.transport for link in subscriber.links] == ["TCPROS"]


def test_programs_that_are_started_inherit_no_socket(linked: Any) -> None:
    before = set(os.listdir("/proc/self/fd"))
    linked()
    inherited = []
    for name in set(os.listdir("/proc/self/fd")) - before:
        with contextlib.suppress(OSError):
            inherited += [os.readlink(f"/proc/self/fd/{name}")] * os.get_inheritable(int(name))
    assert inherited == []


@pytest.mark.slow
def test_a_publisher_keeps_no_memory_for_nobody(linked: Any, until: Any) -> None:
    """After its last subscriber has left, which has read what is in several blocks, and given some back."""
    before = blocks()
    publisher, subscriber, got = linked(queue_size=0, arrays="memoryview")
    for number in range(1, 5):
        if number == 4:
            got.items.clear()
            gc.collect()
        publisher.publish(image(number))
        got.until(lambda items: items and items[-1].height == number)  # noqa: B023
    assert len(blocks() - before) > 1
    got.items.clear()
    subscriber.unregister()
    until(lambda: gc.collect() + 1 and not blocks() - before)
    assert publisher.num_connections == 0


def test_publishers_that_share_nothing(
    make_node: Any, collect: Any, transport: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.same_host.is_local_enabled", lambda setting: False)
    publisher = make_node("talker").advertise("/t", Image, queue_size=5)
    monkeypatch.setattr("pyros1.node.same_host.is_local_enabled", lambda setting: True)
    got = collect()
    subscriber = make_node("listener").subscribe("/t", Image, got)
    assert publisher.wait_for_subscribers(1, PATIENCE) and subscriber.wait_for_publishers(1, PATIENCE)
    assert [link.transport for link in subscriber.links] == ["TCPROS"]


def test_a_subscriber_may_want_tcp(make_node: Any, collect: Any, transport: str) -> None:
    publisher = make_node("talker").advertise("/t", Image, queue_size=5)
    subscriber = make_node("listener").subscribe("/t", Image, collect(), transports="tcp")
    assert publisher.wait_for_subscribers(1, PATIENCE) and subscriber.wait_for_publishers(1, PATIENCE)
    assert [link.transport for link in subscriber.links] == ["TCPROS"]
    with pytest.raises(ValueError, match="add 'tcp'"):
        make_node("other").subscribe("/t", Image, collect(), transports="local")


def test_nodes_share_memory_by_themselves(
    make_node: Any, environ: dict[str, str], collect: Any, transport: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.undo()
    monkeypatch.setattr("pyros1.node.subscribing.connector.find_local_context", lambda uri: None)
    del environ["PYROS1_TRANSPORTS"]
    publisher = make_node("talker").advertise("/t", Image, queue_size=5)
    subscriber = make_node("listener").subscribe("/t", Image, collect())
    assert publisher.wait_for_subscribers(1, PATIENCE) and subscriber.wait_for_publishers(1, PATIENCE)
    assert [link.transport for link in subscriber.links] == ["LOCAL"]


def test_setting(make_node: Any, environ: dict[str, str], transport: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    with pytest.raises(SettingError, match="PYROS1_TRANSPORTS: 'pigeon'"):
        make_node("talker", environ={**environ, "PYROS1_TRANSPORTS": "pigeon"})


def test_a_late_subscriber_gets_a_latched_one_that_nobody_waits_for(linked: Any, make_node: Any, collect: Any) -> None:
    """It is larger than what a socket takes at once, and the publisher, which has no queue, publishes no more."""
    publisher, subscriber, got = linked(queue_size=None, latch=True)
    publisher.publish(image(5, 5_000_000))
    got.wait(1)
    late = collect()
    make_node("late").subscribe(subscriber.name, Image, late)
    assert late.wait(1)[0].data == bytes([5]) * 5_000_000


@pytest.mark.slow
def test_a_forked_process_gives_nothing_back(linked: Any) -> None:
    """What its parent keeps stays as it is when the child ends its own copy."""
    publisher, _, got = linked(queue_size=0, arrays="memoryview")
    for number in range(3):
        publisher.publish(image(number))
    kept = got.wait(3)[:]
    child = os.fork()
    if not child:
        for message in kept:
            message.data = b""
        kept.clear()
        got.items.clear()
        gc.collect()
        os._exit(0)
    os.waitpid(child, 0)
    for number in range(3, 40):
        publisher.publish(image(number))
        got.wait(number + 1)
    assert [set(bytes(message.data)) for message in kept] == [{0}, {1}, {2}]


def test_a_forked_process_may_publish(linked: Any) -> None:
    """Beside its parent: they would number blocks and references alike."""
    publisher, _, got = linked(queue_size=None)
    publisher.publish(image(0))
    got.wait(1)
    child = os.fork()
    if not child:
        with contextlib.suppress(BaseException):
            publisher.publish(image(1, 2 * LARGE))
        os._exit(0)
    os.waitpid(child, 0)
    for number in range(2, 5):
        publisher.publish(image(number, 2 * LARGE))
    assert [(message.height, set(message.data)) for message in got.wait(5)] == [(n, {n}) for n in range(5)]


def test_a_publisher_that_answers_what_nobody_offered(
    make_node: Any, fake_node: Any, collect: Any, transport: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.same_host.is_local_enabled", lambda setting: False)
    fake, got, called = fake_node("/odd"), collect(), collect()
    monkeypatch.setattr("pyros1.node.same_host.connect", called)  # there are systems without such sockets
    fake.answers["requestTopic"] = [1, "ready", ["PYROS1-LOCAL", "pyros1-name"]]
    fake.publish("/t")
    make_node("listener").subscribe("/t", Float64, got)
    fake.calls.until(lambda calls: sum(call[0] == "requestTopic" for call in calls) >= 2)
    fake.answers["requestTopic"] = [1, "ready", ["TCPROS", "localhost", fake.port]]
    fake.accept_subscriber().sendall((8).to_bytes(4, "little") + bytes(8))
    assert got.wait(1)[0].data == 0.0 and not called.items


def blocks() -> set[int]:
    """The blocks of shared memory that this process has, by their numbers in the system."""
    found = {
        int(line.split()[4]) for line in Path("/proc/self/maps").read_text().splitlines() if "memfd:pyros1" in line
    }
    for descriptor in os.listdir("/proc/self/fd"):
        path = f"/proc/self/fd/{descriptor}"
        with contextlib.suppress(OSError):
            if "memfd:pyros1" in os.readlink(path):
                found.add(os.stat(path).st_ino)
    return found


@pytest.mark.slow
def test_nothing_is_left_open(linked: Any, until: Any) -> None:
    before = blocks()  # of messages that failed tests have kept
    publisher, subscriber, got = linked(queue_size=0, arrays="memoryview")
    for number in range(20):
        publisher.publish(image(number))
    got.wait(20)
    assert blocks() - before
    got.items.clear()
    subscriber.unregister()
    publisher.unregister()
    until(lambda: gc.collect() + 1 and not blocks() - before)


@pytest.mark.slow
def test_a_publisher_that_ends_frees_its_memory_without_its_loop(
    make_node: Any, collect: Any, transport: str, until: Any
) -> None:
    """The loop of a node that shuts down makes no more calls."""
    before, talker, got = blocks(), make_node("talker"), collect()
    publisher = talker.advertise("/t", Image, queue_size=0)
    subscriber = make_node("listener").subscribe("/t", Image, got, arrays="memoryview")
    assert publisher.wait_for_subscribers(1, PATIENCE)
    for number in range(3):
        publisher.publish(image(number))
    got.wait(3)
    got.items.clear()
    gc.collect()
    publisher.publish(image(3))  # takes back the others
    got.wait(1)
    got.items.clear()
    busy, leave = threading.Event(), threading.Event()
    context_of(talker).loop.call_soon(lambda: busy.set() or leave.wait(PATIENCE))
    assert busy.wait(PATIENCE)
    try:
        subscriber.unregister()
        publisher.unregister()
        until(lambda: gc.collect() + 1 and not blocks() - before)
    finally:
        leave.set()


KILLED = """
import sys
from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.node import Node
node = Node("killed", argv=[], anonymous=True, handle_signals=False)
if sys.argv[1] == "talker":
    publisher = node.advertise("/t", Image, queue_size=3)
    publisher.wait_for_subscribers()
    number = 0
    while True:
        publisher.publish(Image(height=number, data=bytes([number % 256]) * (100_000 + number % 7 * 50_000)))
        number += 1
        if number == 3:
            print("ready", flush=True)
kept = []
def take(message):
    kept.append(message)
    del kept[:-2]
    if message.height % 5 == 4:
        print("ready", flush=True)
node.subscribe("/t", Image, take, arrays="memoryview", queue_size=2)
sys.stdin.read()
"""


def killed(environ: dict[str, str], role: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", KILLED, role],
        env={**os.environ, **environ, "PYROS1_TRANSPORTS": "local,tcp"},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


@pytest.mark.slow
@pytest.mark.parametrize("role", ["talker", "listener"])
def test_killed(make_node: Any, environ: dict[str, str], transport: str, role: str, collect: Any, until: Any) -> None:
    """Whoever is killed leaves nothing behind, and the others go on."""
    node = make_node("stays")
    ended = threading.Event()
    wrong: list[int] = []

    def look(message: Any) -> None:
        if set(bytes(message.data)) != {message.height % 256}:
            wrong.append(message.height)

    if role == "talker":
        node.subscribe("/t", Image, look, arrays="memoryview", queue_size=2)
        thread = None
    else:
        publisher = node.advertise("/t", Image, queue_size=3)

        def publish() -> None:
            for number in itertools.count():
                if ended.is_set():
                    return
                publisher.publish(image(number, 100_000 + number % 7 * 50_000))
                ended.wait(0.0005)

        thread = threading.Thread(target=publish)
        thread.start()
    try:
        for _ in range(KILLS):
            process = killed(environ, role)
            assert process.stdout is not None
            assert process.stdout.readline() == "ready\n"
            process.kill()
            process.communicate()
        assert not wrong
    finally:
        ended.set()
        if thread is not None:
            thread.join()
    if thread is not None:
        until(lambda: not publisher.num_connections)


def test_a_descriptor_that_is_no_socket_is_not_kept(
    make_node: Any, fake_node: Any, collect: Any, transport: str, until: Any
) -> None:
    """Each attempt would leave one open."""
    fake, got = fake_node("/odd"), collect()
    listener, name = listen()
    with listener:
        fake.answers["requestTopic"] = [1, "ready", ["PYROS1-LOCAL", name]]
        fake.publish("/t")
        make_node("listener").subscribe("/t", Float64, got)
        peer, _ = listener.accept()
        fields = {"callerid": "/odd", "topic": "/t", "type": "std_msgs/Float64", "md5sum": Float64._md5sum}
        reading, writing = os.pipe()
        with peer:
            socket.send_fds(peer, [encode_header({**fields, "token": "00" * 16})], [writing])
            os.close(writing)
            assert os.read(reading, 1) == b"", "nobody has the other end"
        os.close(reading)
