"""Playing bags to nodes in this process.

Feature: bags: playing -- `/clock`, seek with latched topics, pause, step, several bags
"""

from __future__ import annotations

import itertools
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from pyros1.bag import BagWriter
from pyros1.bag.format.files import BagFile
from pyros1.bag.format.reader import BagReader
from pyros1.bag.play.clock import Ticker, Timeline
from pyros1.bag.play.control import Control
from pyros1.bag.play.player import Player, PlayOptions, Status
from pyros1.bag.play.read_ahead import BagSet, PlayItem, ReadAhead
from pyros1.msgs import AnyMsg
from pyros1.msgs.rosgraph_msgs.msg import Clock
from pyros1.msgs.std_msgs.msg import Float64, Header, String

from ...bodies import encode

PATIENCE = 20.0
BEGIN = 1_700_000_000 * 10**9
MS = 10**6


def fields(cls: Any, **more: str) -> dict[str, bytes]:
    header = {"type": cls._type, "md5sum": cls._md5sum, "message_definition": cls._full_text, **more}
    return {name: value.encode() for name, value in header.items()}


def write_numbers(path: Path, topic: str, times: Any, **more: str) -> Path:
    """A bag with a Float64 at each time, in ms, which is its value too."""
    with BagWriter(path, chunk_threshold=1000) as bag:
        conn = bag.add_connection(topic, fields(Float64, callerid="/talker", **more))
        for time in times:
            bag.write(conn, BEGIN + int(time * MS), struct.pack("<d", time))
    return path


class Ear:
    """A node that keeps what it hears."""

    def __init__(self, node: Any) -> None:
        self.heard: list[tuple[str, Any]] = []
        self._node = node
        self._changed = threading.Condition()

    def listen(self, topic: str, cls: Any = Float64) -> Any:
        def take(message: Any) -> None:
            with self._changed:
                self.heard.append((topic, message))
                self._changed.notify_all()

        return self._node.subscribe(topic, cls, take)

    def values(self, topic: str) -> list[float]:
        return [message.data for name, message in self.heard if name == topic]

    def wait(self, count: int) -> list[tuple[str, Any]]:
        with self._changed:
            assert self._changed.wait_for(lambda: len(self.heard) >= count, PATIENCE), self.heard
            return list(self.heard)


@pytest.fixture
def ear(make_node: Any) -> Ear:
    return Ear(make_node("ear"))


@pytest.fixture
def control() -> Iterator[Control]:
    made = Control()
    yield made
    made.close()


@pytest.fixture
def playing(make_node: Any, control: Control) -> Callable[..., Any]:
    """Return a context manager that plays bags in a thread, once the ear is connected; yields the player."""

    @contextmanager
    def run(
        paths: list[Path],
        topics: Any = None,
        expect: Any = (),
        on_status: Callable[[Status], object] | None = None,
        prepare: Callable[[Player], object] = lambda player: None,
        **settings: Any,
    ) -> Iterator[Player]:
        with BagSet([str(path) for path in paths], topics) as bags:
            player = Player(make_node("play"), bags, PlayOptions(**settings), control, on_status)
            prepare(player)
            for subscriber in expect:
                assert subscriber.wait_for_publishers(timeout=PATIENCE)
            thread = threading.Thread(target=player.run)
            thread.start()
            try:
                yield player
                thread.join(PATIENCE)
                assert not thread.is_alive()
            finally:
                control.end()
                thread.join(PATIENCE)

    return run


# Time -----------------------------------------------------------------------------------------------------------------


def test_timeline_flows_at_its_rate_and_stands_while_held() -> None:
    line = Timeline(2.0)
    line.set(BEGIN, 10.0)
    assert line.bag_time_at(10.5) == BEGIN + 1000 * MS
    assert line.wall_time_at(BEGIN + 4000 * MS) == pytest.approx(12.0)
    line.set_paused(11.0, True)
    line.set_paused(11.5, True)
    assert line.bag_time_at(100.0) == BEGIN + 2000 * MS
    line.set_paused(20.0, False)
    assert line.bag_time_at(20.5) == BEGIN + 3000 * MS


def test_ticker_keeps_step_and_leaves_out_what_it_missed() -> None:
    ticker = Ticker(0.01)
    ticker.due_at = 1.0
    ticker.tick(1.003)
    assert ticker.due_at == pytest.approx(1.01)
    ticker.tick(2.0)
    assert ticker.due_at == pytest.approx(2.01)


# Messages -------------------------------------------------------------------------------------------------------------


def test_frames_are_published_as_stored(tmp_path: Path, ear: Ear, playing: Any, transport: str) -> None:
    """Types that exist nowhere, latched topics, headers whose seq stays as it is (B40)."""
    path = tmp_path / "x.bag"
    header = Header(seq=77, frame_id="map")
    with BagWriter(path) as bag:
        odd = {"type": b"nowhere/Odd", "md5sum": b"0" * 32, "message_definition": b"uint8 x\n"}
        for index, (topic, data, kind) in enumerate(
            [("/odd", b"\x07", odd), ("/head", encode(header), fields(Header, latching="1"))]
        ):
            bag.write(bag.add_connection(topic, kind), BEGIN + index, data)
    subscribers = [ear.listen("/odd", AnyMsg), ear.listen("/head", Header)]
    with playing([path], expect=subscribers):
        pass
    heard = dict(ear.wait(2))
    assert heard["/odd"]._buff == b"\x07"
    assert heard["/odd"]._connection_header["message_definition"] == "uint8 x\n"
    assert heard["/head"] == header
    assert heard["/head"]._connection_header["latching"] == "1"


def test_bags_are_merged_by_time(tmp_path: Path, ear: Ear, playing: Any) -> None:
    one = write_numbers(tmp_path / "one.bag", "/t", range(0, 60, 3))
    two = write_numbers(tmp_path / "two.bag", "/t", range(1, 60, 3))
    three = write_numbers(tmp_path / "three.bag", "/t", range(2, 60, 3))
    with playing([three, one, two], expect=[ear.listen("/t")]):
        pass
    ear.wait(60)
    assert ear.values("/t") == list(map(float, range(60)))


def test_part_of_the_bag_topics_and_prefix(tmp_path: Path, ear: Ear, playing: Any, make_node: Any) -> None:
    path = write_numbers(tmp_path / "x.bag", "/t", range(100))
    other = write_numbers(tmp_path / "y.bag", "/other", range(100))
    subscriber = ear.listen("/p/t")
    with playing([path, other], topics=["/t"], expect=[subscriber], prefix="/p", start=0.05, duration=0.02):
        published = {topic for topic, _ in make_node("looker").master.get_published_topics()}
        assert published - {"/rosout", "/clock"} == {"/p/t"}
    ear.wait(21)
    assert ear.values("/p/t") == list(map(float, range(50, 71)))


def test_what_was_latched_before_the_start_comes_first(tmp_path: Path, ear: Ear, playing: Any) -> None:
    """B32: of each publisher the last one, though it is chunks away; what does not latch is left out."""
    path = tmp_path / "x.bag"
    with BagWriter(path, chunk_threshold=500) as bag:
        static = [
            bag.add_connection("/tf_static", fields(String, callerid=name, latching="1")) for name in ("/a", "/b")
        ]
        plain = bag.add_connection("/t", fields(Float64, callerid="/c"))
        for time, conn, text in [(0, 0, "old a"), (1, 0, "new a"), (2, 1, "b"), (900, 1, "late b")]:
            bag.write(static[conn], BEGIN + time * MS, encode(String(text)))
            for step in range(100):
                bag.write(plain, BEGIN + (time + step // 50) * MS, struct.pack("<d", time))
    with BagReader(path) as bag_read:
        assert len(bag_read.chunks) > 10
    with playing([path], expect=[ear.listen("/tf_static", String), ear.listen("/t")], start=0.5):
        pass
    ear.wait(2 + 1 + 100)
    assert [message.data for topic, message in ear.heard if topic == "/tf_static"] == ["new a", "b", "late b"]
    assert ear.values("/t") == [900.0] * 100


def test_topics_whose_types_differ_are_named(tmp_path: Path, playing: Any) -> None:
    one = write_numbers(tmp_path / "one.bag", "/t", range(3))
    two = tmp_path / "two.bag"
    with BagWriter(two) as bag:
        bag.write(bag.add_connection("/t", fields(String, callerid="/other")), BEGIN, encode(String("x")))
    with playing([one, two]) as player:
        assert list(player.unplayable) == ["/t"] and "std_msgs/Float64" in player.unplayable["/t"]


# The user's wishes ----------------------------------------------------------------------------------------------------


def test_pause_step_and_go_on(tmp_path: Path, ear: Ear, playing: Any, control: Control) -> None:
    path = write_numbers(tmp_path / "x.bag", "/t", range(0, 200, 2))
    control.is_paused = True
    states: list[Status] = []
    with playing(
        [path], expect=[ear.listen("/t"), ear.listen("/clock", Clock)], on_status=states.append, clock_rate=50
    ):
        for count in (1, 2, 3):
            control.step()
            clock = BEGIN + 2 * MS * (count - 1)  # it is brought to the message; a later one may replace it
            while len(_numbers(ear)) < count or clock not in _clocks(ear):
                ear.wait(len(ear.heard) + 1)
        assert _numbers(ear) == [0.0, 2.0, 4.0]
        while not any(state.state == "PAUSED" for state in states):
            ear.wait(len(ear.heard) + 1)
        assert not control.set_paused(True)
        assert control.set_paused(False)
    while len(_numbers(ear)) < 100:
        ear.wait(len(ear.heard) + 1)
    assert _numbers(ear) == list(map(float, range(0, 200, 2)))
    assert _clocks(ear) == sorted(_clocks(ear))


def _clocks(ear: Ear) -> list[int]:
    return [message.clock.to_nsec() for topic, message in list(ear.heard) if topic == "/clock"]


def _numbers(ear: Ear) -> list[float]:
    return [message.data for topic, message in list(ear.heard) if topic == "/t"]


def test_pause_before_messages_of_a_topic(tmp_path: Path, ear: Ear, playing: Any, control: Control) -> None:
    """B35: such a message is played when the user steps or goes on."""
    path = write_numbers(tmp_path / "x.bag", "/t", range(20))
    stop = write_numbers(tmp_path / "y.bag", "/stop", [10])
    states: list[Status] = []
    paused = threading.Event()

    def note(status: Status) -> None:
        states.append(status)
        if status.state == "PAUSED":
            paused.set()

    expect = [ear.listen("/t"), ear.listen("/stop")]
    with playing([path, stop], expect=expect, on_status=note, pause_topics=["/stop"]):
        assert paused.wait(PATIENCE)
        ear.wait(10)
        assert _numbers(ear)[-1] in (9.0, 10.0)
        assert not ear.values("/stop")
        control.toggle()
    ear.wait(21)
    assert ear.values("/stop") == [10.0] and len(_numbers(ear)) == 20


def test_loop_begins_again_until_the_end(tmp_path: Path, ear: Ear, playing: Any, control: Control) -> None:
    path = write_numbers(tmp_path / "x.bag", "/t", range(10))
    with playing([path], expect=[ear.listen("/t")], loop=True):
        ear.wait(35)
        control.end()
    assert ear.values("/t")[:30] == list(map(float, range(10))) * 3


def test_gaps_are_skipped_and_nothing_is_waited_for(tmp_path: Path, ear: Ear, playing: Any) -> None:
    """A day between two messages takes no time, by either option."""
    day = 86_400_000.0
    path = write_numbers(tmp_path / "x.bag", "/t", [0, 1, day, day + 1])
    subscriber = ear.listen("/t")
    with playing([path], expect=[subscriber], skip_empty=10.0):
        pass
    ear.wait(4)
    assert ear.values("/t") == [0, 1, day, day + 1]


def test_immediate_steps_the_clock(tmp_path: Path, ear: Ear, playing: Any) -> None:
    day = 86_400_000.0
    path = write_numbers(tmp_path / "x.bag", "/t", [0, day])
    with playing([path], expect=[ear.listen("/t"), ear.listen("/clock", Clock)], immediate=True, clock_rate=10):
        pass
    end = BEGIN + int(day) * MS

    def clocks() -> list[int]:
        return [message.clock.to_nsec() for topic, message in list(ear.heard) if topic == "/clock"]

    while len(ear.values("/t")) < 2 or end not in clocks():
        ear.wait(len(ear.heard) + 1)
    assert set(clocks()) <= {BEGIN, end} and clocks()[-1] == end  # a queue of one: the first may be overtaken


@pytest.mark.slow
@pytest.mark.parametrize("rate", [0.1, 4.0])
def test_clock_is_steady_and_never_ahead_of_what_comes_next(
    tmp_path: Path, ear: Ear, playing: Any, rate: float
) -> None:
    path = write_numbers(tmp_path / "x.bag", "/t", range(0, 300, 10))
    with playing(
        [path], expect=[ear.listen("/t"), ear.listen("/clock", Clock)], clock_rate=200.0, rate=rate, start=0.1
    ):
        pass
    ear.wait(20)
    clocks = [message.clock.to_nsec() for topic, message in ear.heard if topic == "/clock"]
    assert clocks[0] >= BEGIN + 100 * MS, (
        "not before the first message that is played; a later tick may overtake the first"
    )
    assert clocks == sorted(clocks) and clocks[-1] <= BEGIN + 290 * MS
    assert len(clocks) <= (0.19 / rate) * 200 + 2, "no tick twice"
    assert len(clocks) > 1 or rate > 1, "it ticks; when exactly, a busy machine decides, and the tests of Ticker"


def test_the_pace_follows_a_topic(tmp_path: Path, ear: Ear, playing: Any, control: Control) -> None:
    """B38: playing waits while the newest stamp lags behind by more than the limit."""
    path = write_numbers(tmp_path / "x.bag", "/t", range(0, 500, 10))
    delayed = threading.Event()

    def note(status: Status) -> None:
        if status.state == "DELAYED":
            delayed.set()

    def prepare(player: Player) -> None:
        player.rate_stamp = 0

    with playing([path], expect=[ear.listen("/t")], on_status=note, prepare=prepare, max_delay=0.1) as player:
        assert delayed.wait(PATIENCE)
        assert max(ear.values("/t")) <= 110
        player.rate_stamp = BEGIN + 10**12
        control.wake()
    ear.wait(50)
    assert len(ear.values("/t")) == 50


# Reading --------------------------------------------------------------------------------------------------------------


def test_reading_ahead_is_bounded_and_ends(tmp_path: Path) -> None:
    path = write_numbers(tmp_path / "x.bag", "/t", range(10))
    with BagReader(path) as bag:
        message = next(bag.messages())
    taken = itertools.count()
    large = message._replace(data=bytes(1 << 20))
    produced: list[int] = []

    def endless() -> Iterator[PlayItem]:
        for number in taken:
            produced.append(number)
            yield PlayItem(0, large)

    with ReadAhead(endless(), limit=4 << 20) as source:
        for _ in range(3):
            batch = source.take(PATIENCE)
            assert batch
        assert len(produced) <= 3 + 4 + 3


def test_an_error_while_reading_is_raised_to_who_takes(tmp_path: Path) -> None:
    def broken() -> Iterator[PlayItem]:
        raise OSError("gone")
        yield

    with ReadAhead(broken()) as source, pytest.raises(OSError, match="gone"):
        while source.take(PATIENCE) is not None:
            pass


def test_only_the_index_is_read_before_the_first_message(tmp_path: Path, monkeypatch: Any) -> None:
    """Of a bag of 100 MB in 400 chunks; the read-ahead may take its share."""
    path = tmp_path / "large.bag"
    with BagWriter(path, chunk_threshold=1) as bag:
        conn = bag.add_connection("/t", fields(String, callerid="/talker", latching="1"))
        for number in range(400):
            bag.write(conn, BEGIN + number * MS, bytes(250_000))
    sizes: list[int] = []
    read = BagFile.read

    def counting(self: BagFile, position: int, size: int) -> bytes:
        data = read(self, position, size)
        sizes.append(len(data))
        return data

    monkeypatch.setattr(BagFile, "read", counting)
    with BagSet([str(path)]) as bags:
        assert bags.end - bags.start == 399 * MS
        assert len(bags.latched_messages_before(BEGIN + 200 * MS)) == 1
        first = next(iter(bags.messages(BEGIN + 300 * MS, BEGIN + 400 * MS)))
        assert first.message.time == BEGIN + 300 * MS
        assert sum(sizes) < 2_000_000
