"""Recording topics of nodes in this process, and in others, into files.

Feature: bags: recording -- messages are stored undecoded with their headers, and written to disk every second;
    dropped messages are counted per topic
"""

from __future__ import annotations

import os
import random
import re
import resource
import signal
import threading
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pyros1.bag.errors import BagError
from pyros1.bag.format.reader import BagReader
from pyros1.bag.record.file_names import FileNames
from pyros1.bag.record.model import RecordOptions
from pyros1.bag.record.recorder import Events, Recorder
from pyros1.msgs import AnyMsg
from pyros1.msgs.std_msgs.msg import Float64, Header, String
from pyros1.wire.handshake import TopicType

from ...bodies import decode

DEADLINE = 20.0


def until(reached: Callable[[], Any], what: str = "", timeout: float = DEADLINE) -> Any:
    end = time.monotonic() + timeout
    while not (value := reached()):
        assert time.monotonic() < end, f"not in time: {what}"
        time.sleep(0.01)
    return value


def options(folder: Path, **settings: Any) -> RecordOptions:
    names = FileNames(str(folder / "r"), has_date=False, has_number=bool(settings.get("split")))
    return RecordOptions(names=names, min_space=0, **settings)


def numbers(path: str | Path, topic: str = "/t") -> list[float]:
    """The values of the Float64 messages of a bag's topic."""
    with BagReader(path) as bag:
        return [decode(Float64, m.data).data for m in bag.messages(bag.connection_ids([topic]))]


def topics_of(path: Path) -> set[str]:
    """The topics of a bag, also of one that is being recorded."""
    with BagReader(path, unindexed=True) as bag:
        return {connection.topic for connection in bag.connections.values()}


def test_latched_messages_are_kept_in_memory_only_to_be_repeated(tmp_path: Path, make_node: Any) -> None:
    """Each run of `rostopic pub -1` is another latching publisher."""
    talker, size = make_node("talker"), 1 << 20
    with Recorder(make_node("record"), options(tmp_path)) as recorder:
        recorder.subscribe("/t")
        tracemalloc.start()
        try:
            for number in range(10):
                with talker.advertise("t", String, latch=True, headers={"number": str(number)}) as publisher:
                    publisher.publish(f"{number:{size}}")
                    until(lambda: recorder.topics["/t"].messages == number + 1, "message")  # noqa: B023
                until(lambda: not recorder.topics["/t"].subscriber.links, "disconnected")
            until(lambda: recorder.size > 9 * size, "written")
            until(lambda: tracemalloc.get_traced_memory()[0] < 5 * size, "freed")
        finally:
            tracemalloc.stop()


def test_frames_and_headers_are_kept_as_they_came(tmp_path: Path, make_node: Any, transport: str) -> None:
    talker = make_node("talker")
    plain = talker.advertise("t", Float64, queue_size=0, headers={"cookie": "a=b"})
    latched = talker.advertise("latched", String, latch=True)
    latched.publish("stays")
    unknown = talker.advertise(
        "odd", AnyMsg, raw_type=TopicType("nowhere/Odd", "0123456789abcdef0123456789abcdef", "uint8 x # grün\n")
    )
    opened: list[str] = []
    with Recorder(make_node("record"), options(tmp_path), Events(on_opened=opened.append)) as recorder:
        for name in ("/t", "/latched", "/odd"):
            recorder.subscribe(name)
        assert plain.wait_for_subscribers(timeout=DEADLINE) and unknown.wait_for_subscribers(timeout=DEADLINE)
        for value in range(100):
            plain.publish(float(value))
        unknown.publish(AnyMsg(b"\x07"))
        until(lambda: [topic.messages for topic in recorder.topics.values()] == [100, 1, 1], "messages")
        assert os.path.exists(opened[0] + ".active") and not os.path.exists(opened[0])
    assert not os.path.exists(opened[0] + ".active")
    assert numbers(opened[0]) == list(map(float, range(100)))
    assert (recorder.report.messages, recorder.report.files) == (102, opened)
    with BagReader(opened[0]) as bag:
        by_topic = {connection.topic: connection for connection in bag.connections.values()}
        assert by_topic["/t"].callerid == "/talker" and by_topic["/t"].text("cookie") == "a=b"
        assert by_topic["/t"].definition == Float64._full_text and by_topic["/t"].md5sum == Float64._md5sum
        assert by_topic["/latched"].latching and not by_topic["/t"].latching
        assert by_topic["/odd"].definition == "uint8 x # grün\n" and by_topic["/odd"].type == "nowhere/Odd"
        odd = next(bag.messages(bag.connection_ids(["/odd"])))
        assert odd.data == b"\x07" and abs(odd.time / 1e9 - time.time()) < 3600


@pytest.mark.parametrize("compression", ["none", "bz2", "lz4"])
def test_splits_repeat_what_is_latched_and_forget_the_oldest(tmp_path: Path, make_node: Any, compression: str) -> None:
    talker = make_node("talker")
    talker.advertise("latched", String, latch=True).publish("stays")
    noise = random.Random(1)
    bulk = talker.advertise("bulk", String, queue_size=0)
    settings = options(
        tmp_path, split=True, max_size=100_000, max_splits=2, chunk_size=10_000, compression=compression,
        repeat_latched=True,
    )  # fmt: skip
    with Recorder(make_node("record"), settings) as recorder:
        recorder.subscribe("/latched")
        until(lambda: recorder.topics["/latched"].messages)
        recorder.subscribe("/bulk")
        assert bulk.wait_for_subscribers(timeout=DEADLINE)
        for _ in range(600):
            bulk.publish("".join(noise.choices("abcdefghijklmnopqrstuvwxyz0123456789", k=1000)))
        until(lambda: recorder.topics["/bulk"].messages == 600)
    files = sorted(path.name for path in tmp_path.glob("r_*.bag"))
    assert len(recorder.report.files) > 3
    assert files == [Path(name).name for name in recorder.report.files[-3:]], "two closed ones and the last"
    for name in files:
        with BagReader(tmp_path / name) as bag:
            assert bag.count(bag.connection_ids(["/latched"])) == 1
            assert {bag.header(chunk).compression for chunk in bag.chunks} == {compression}
            assert bag.file.size < 130_000


def test_without_split_a_limit_ends_the_recording(tmp_path: Path, make_node: Any) -> None:
    publisher = make_node("talker").advertise("t", Float64, queue_size=0)
    ended = threading.Event()
    with Recorder(
        make_node("record"), options(tmp_path, max_size=20_000, chunk_size=1000), Events(on_ended=ended.set)
    ) as recorder:
        recorder.subscribe("/t")
        assert publisher.wait_for_subscribers(timeout=DEADLINE)
        for value in range(2000):
            publisher.publish(float(value))
        assert ended.wait(DEADLINE)
    assert recorder.error is None
    assert 20_000 < os.path.getsize(tmp_path / "r.bag") < 40_000
    recorded = numbers(tmp_path / "r.bag")
    assert recorded == list(map(float, range(len(recorded))))


def test_a_full_buffer_drops_the_oldest_and_counts_them(tmp_path: Path, make_node: Any, monkeypatch: Any) -> None:
    """The disk is slow: nothing is written before all has come."""
    publisher = make_node("talker").advertise("t", Float64, queue_size=0)
    warnings: list[str] = []
    all_came = False
    from pyros1.bag.record.queue import RecordQueue

    take = RecordQueue.take

    def slow_take(queue: Any, timeout: float) -> Any:
        if not all_came:
            time.sleep(0.01)
            return []
        return take(queue, timeout)

    monkeypatch.setattr(RecordQueue, "take", slow_take)
    with Recorder(
        make_node("record"), options(tmp_path, buffer_size=10_000), Events(on_warning=warnings.append)
    ) as recorder:
        recorder.subscribe("/t")
        assert publisher.wait_for_subscribers(timeout=DEADLINE)
        for value in range(500):
            publisher.publish(float(value))
        topic = recorder.topics["/t"]
        until(lambda: topic.messages == 500)
        all_came = True
    messages_at = 500 - topic.dropped
    assert messages_at == 10_000 // 258
    assert numbers(tmp_path / "r.bag") == list(map(float, range(500 - messages_at, 500)))
    assert len(warnings) == 1 and "buffer exceeded" in warnings[0]


def test_a_publisher_that_comes_again_is_the_same_connection(tmp_path: Path, make_node: Any) -> None:
    talker = make_node("talker")
    with Recorder(make_node("record"), options(tmp_path)) as recorder:
        recorder.subscribe("/t")
        for round_ in range(1, 4):
            with talker.advertise("t", Float64, queue_size=0) as publisher:
                assert publisher.wait_for_subscribers(timeout=DEADLINE)
                publisher.publish(float(round_))
                until(lambda count=round_: recorder.topics["/t"].messages == count)
            until(lambda: recorder.topics["/t"].subscriber.num_connections == 0)
    assert numbers(tmp_path / "r.bag") == [1.0, 2.0, 3.0]
    with BagReader(tmp_path / "r.bag") as bag:
        assert len(bag.connections) == 1


def test_too_little_space_is_said_at_once(tmp_path: Path, make_node: Any) -> None:
    settings = RecordOptions(names=FileNames(str(tmp_path / "r"), has_date=False), min_space=1 << 60)
    with pytest.raises(BagError, match="space"):
        Recorder(make_node("record"), settings)
    assert not list(tmp_path.glob("r*"))


def test_two_recordings_of_one_name(tmp_path: Path, make_node: Any) -> None:
    node = make_node("record")
    with Recorder(node, options(tmp_path)), pytest.raises(BagError, match="another recording"):
        Recorder(node, options(tmp_path))
    assert os.listdir(tmp_path) == ["r.bag"]


def test_what_a_killed_recording_left_is_kept(tmp_path: Path, make_node: Any) -> None:
    talker = make_node("talker")
    talker.advertise("t", Float64, latch=True).publish(1.0)
    active = tmp_path / "r.bag.active"
    for size in (0, 4117, 5000, 6000):
        active.write_bytes(bytes(size))
        warnings: list[str] = []
        with Recorder(make_node("record"), options(tmp_path), Events(on_warning=warnings.append)) as recorder:
            recorder.subscribe("/t")
            until(lambda now=recorder: now.topics["/t"].messages == 1)
        assert len(warnings) == (size > 4117) == ("bag reindex" in "".join(warnings))
        assert numbers(tmp_path / "r.bag") == [1.0]
    assert [(tmp_path / f"r.bag.active.{i}").stat().st_size for i in (1, 2)] == [5000, 6000]


def test_a_folder_of_that_name_is_said_at_once(tmp_path: Path, make_node: Any) -> None:
    (tmp_path / "r.bag").mkdir()
    with pytest.raises(IsADirectoryError):
        Recorder(make_node("record"), options(tmp_path))


def test_the_clock_may_leap_and_begin_anew(tmp_path: Path, make_node: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    now = 100 * 10**9
    monkeypatch.setattr("pyros1.bag.record.recorder.make_clock", lambda node: lambda: now)
    publisher = make_node("talker").advertise("t", Float64, queue_size=0)
    with Recorder(make_node("record"), options(tmp_path, split=True, max_duration=1e-3)) as recorder:
        recorder.subscribe("/t")
        assert publisher.wait_for_subscribers(timeout=DEADLINE)
        for value, now in enumerate((100 * 10**9, 4 * 10**18, 5 * 10**9, 5 * 10**9 + 2 * 10**6)):  # noqa: B007
            publisher.publish(float(value))
            until(lambda count=value + 1: recorder.topics["/t"].messages == count)
    assert [numbers(path) for path in recorder.report.files] == [[0.0], [2.0, 1.0], [3.0]]


def test_a_split_that_cannot_be_opened_ends_the_recording_and_all_is_counted(
    tmp_path: Path, make_node: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "r_1.bag").mkdir()
    publisher = make_node("talker").advertise("t", String, queue_size=0)
    recorder = Recorder(make_node("record"), options(tmp_path, split=True, max_size=100_000))
    recorder.subscribe("/t")
    assert publisher.wait_for_subscribers(timeout=DEADLINE)
    while recorder.error is None:
        publisher.publish("x" * 10_000)
        time.sleep(0.001)
    recorder.close()
    assert isinstance(recorder.error, IsADirectoryError)
    topic = recorder.topics["/t"]
    with BagReader(tmp_path / "r_0.bag") as bag:
        assert topic.written == bag.count() > 0 and topic.dropped > 0


@pytest.mark.slow
def test_limit_per_topic(start: Any, make_node: Any, tmp_path: Path) -> None:
    talker = make_node("talker")
    publishers = [talker.advertise(name, Float64) for name in ("a", "b")]
    recorder = start("bag", "record", "-l", "3", "-O", "limited", "a", "/b")
    for publisher in publishers:
        assert publisher.wait_for_subscribers(timeout=DEADLINE)
    for value in range(10):
        for publisher in publishers:
            publisher.publish(float(value))
    out, err = recorder.communicate(timeout=DEADLINE)
    assert (recorder.returncode, err) == (0, "")
    assert "6 messages" in out
    assert numbers(tmp_path / "limited.bag", "/a") == numbers(tmp_path / "limited.bag", "/b") == [0.0, 1.0, 2.0]


@pytest.mark.slow
def test_all_topics_as_they_come_up_but_those_excluded(start: Any, make_node: Any, tmp_path: Path) -> None:
    talker = make_node("talker", rosout=False)
    talker.advertise("first", Float64, latch=True).publish(1.0)
    talker.advertise("secret/x", Float64, latch=True).publish(1.0)
    recorder = start("bag", "record", "-x", "/secret.*|/rosout", "-o", "all", "-p")
    assert "Recording to 'all_" in recorder.stdout.readline()
    assert "Subscribing to /first" in recorder.stdout.readline() + recorder.stdout.readline()
    heard: list[str] = []
    talker.subscribe("begin_write", String, lambda message: heard.append(message.data))
    later = talker.advertise("later", Header)
    assert later.wait_for_subscribers(timeout=DEADLINE)
    later.publish(Header(frame_id="x"))
    until(lambda: heard)
    until(lambda: "/later" in topics_of(tmp_path / (heard[0] + ".active")), "a flushed chunk")
    assert re.fullmatch(r"all_\d{4}(-\d\d){5}\.bag", heard[0])
    recorder.send_signal(signal.SIGTERM)
    _, err = recorder.communicate(timeout=DEADLINE)
    assert recorder.returncode == 0 and "recording all topics" in err
    topics = topics_of(tmp_path / heard[0])
    assert {"/first", "/later"} <= topics and not topics & {"/secret/x", "/rosout"}


@pytest.mark.slow
def test_topics_of_a_node_and_by_expression(start: Any, make_node: Any, tmp_path: Path) -> None:
    talker = make_node("talker")
    for name in ("wanted", "other", "cam1", "cam12"):
        talker.advertise(name, Float64, latch=True).publish(1.0)
    make_node("listener").subscribe("wanted", Float64, lambda message: None)
    of_node = start("bag", "record", "--node", "/listener", "-O", "of_node")
    by_expression = start("bag", "record", "-e", "/cam.", "-O", "by_expression")
    for child in (of_node, by_expression):
        child.stdout.readline()
        assert "Subscribing to" in child.stdout.readline()
    until(lambda: (tmp_path / "of_node.bag.active").stat().st_size > 4117 + 100, "a flushed chunk")
    until(lambda: (tmp_path / "by_expression.bag.active").stat().st_size > 4117 + 100, "a flushed chunk")
    for child in (of_node, by_expression):
        child.send_signal(signal.SIGINT)
        child.communicate(timeout=DEADLINE)
    assert numbers(tmp_path / "of_node.bag", "/wanted") == [1.0]
    assert numbers(tmp_path / "by_expression.bag", "/cam1") == [1.0]
    assert topics_of(tmp_path / "of_node.bag") == {"/wanted"}
    assert topics_of(tmp_path / "by_expression.bag") == {"/cam1"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        ([], 2, "-a"),
        (["-o", "a", "-O", "b", "t"], 2, "both"),
        (["--split", "t"], 2, "duration or size"),
        (["--duration", "5x", "t"], 2, "5x"),
        (["--size", "-1", "t"], 2, "negative"),
        (["-e", "("], 1, "not a regular expression"),
        (["-a", "-l", "3"], 1, "limit"),
        (["-O", "nowhere/x", "t"], 1, "nowhere/x.bag.active"),
        (["--snapshot", "--snapshot-size", "nan", "t"], 2, "must be a non-negative number"),
        (["/"], 1, "'/' is not a legal topic name"),
        (["--min-space", "1000T", "t"], 1, "min-space"),
    ],
)
def test_wrong_arguments(start: Any, words: list[str], code: int, text: str) -> None:
    """L112"""
    child = start("bag", "record", *words)
    _, err = child.communicate(timeout=DEADLINE)
    assert child.returncode == code and text in err


@pytest.mark.slow
def test_a_full_disk_closes_the_file_properly(start: Any, make_node: Any, tmp_path: Path) -> None:
    """Feature: a full disk -- the bag is closed properly, and lost messages are counted"""
    publisher = make_node("talker").advertise("t", Float64, queue_size=0)

    def small_files() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))

    child = start("bag", "record", "-O", "full", "--chunksize", "16", "/t", preexec_fn=small_files)
    assert publisher.wait_for_subscribers(timeout=DEADLINE)
    value = 0
    while child.poll() is None:
        publisher.publish(float(value))
        value += 1
        if value % 1000 == 0:
            time.sleep(0.01)
    out, err = child.communicate(timeout=DEADLINE)
    assert child.returncode == 1 and "File too large" in err
    recorded = numbers(tmp_path / "full.bag")
    assert len(recorded) > 1000 and recorded == list(map(float, range(len(recorded))))
    assert re.search(rf"^{len(recorded)} messages", out, re.MULTILINE)
    counted = re.search(r"/t +(\d+) messages .* (\d+) dropped", out)
    assert counted is not None and int(counted[1]) == len(recorded) and int(counted[2]) > 0


@pytest.mark.slow
def test_kill_loses_at_most_what_was_not_flushed(start: Any, make_node: Any, tmp_path: Path) -> None:
    """At random moments: all messages sent a while before the end are there, whole and in order, none twice.

    Feature: a recorder that is killed -- all flushed messages are in the bag, complete and in order
    """
    publisher = make_node("talker").advertise("t", Float64, queue_size=0)
    moments, count = random.Random(7), 3
    children = [start("bag", "record", "-O", f"killed{number}", "/t") for number in range(count)]
    until(lambda: publisher.num_connections == count, "the recorders")
    sent: list[tuple[float, float]] = []
    ends = {child: time.monotonic() + moments.uniform(3.0, 4.5) for child in children}
    while ends:
        sent.append((time.time(), float(len(sent))))
        publisher.publish(sent[-1][1])
        time.sleep(0.0005)
        for child in [child for child, end in ends.items() if time.monotonic() > end]:
            child.kill()
            del ends[child]
    for number, child in enumerate(children):
        child.wait(DEADLINE)
        path = tmp_path / f"killed{number}.bag.active"
        with BagReader(path, unindexed=True) as bag:
            found = [(m.time / 1e9, decode(Float64, m.data).data) for m in bag.messages()]
        assert bag.was_scanned
        assert [value for _, value in found] == list(map(float, range(len(found)))), "a whole beginning"
        flushed = path.stat().st_mtime
        # A recorder that gets no processor for a while has messages in its sockets.
        before = [value for moment, value in sent if moment < flushed - 2.0]
        assert len(found) >= len(before)
        assert start("bag", "reindex", "-q", str(path)).wait(DEADLINE) == 0
        assert numbers(path) == [value for _, value in found]
    until(lambda: not publisher.num_connections, "the end of the links")


@pytest.mark.slow
def test_sim_time_is_recorded(start: Any, make_node: Any, tmp_path: Path) -> None:
    from pyros1.ground.timing import Time
    from pyros1.msgs.rosgraph_msgs.msg import Clock

    node = make_node("talker")
    node.params["/use_sim_time"] = True
    clock = node.advertise("clock", Clock, latch=True)
    publisher = node.advertise("t", Float64, queue_size=0)
    child = start("bag", "record", "-O", "sim", "/t")
    assert clock.wait_for_subscribers(timeout=DEADLINE)
    clock.publish(Time(100, 0))
    assert publisher.wait_for_subscribers(timeout=DEADLINE)
    publisher.publish(1.0)
    until(lambda: (tmp_path / "sim.bag.active").stat().st_size > 4117 + 100, "a flushed chunk")
    child.send_signal(signal.SIGINT)
    child.communicate(timeout=DEADLINE)
    with BagReader(tmp_path / "sim.bag") as bag:
        assert [message.time for message in bag.messages()] == [100 * 10**9]
