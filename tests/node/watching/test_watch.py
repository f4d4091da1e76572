"""Node.watch: word of another node that ends, hangs, is replaced or comes back.

Feature: notification when a node dies, hangs, is replaced, comes back, or disappears with its machine
"""

from __future__ import annotations

import random
import socket
import threading
import time
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.ground.errors import DeadlineError, NodeShutdownError, UnreachableError
from pyros1.master.server import Master
from pyros1.node.watching.liveness import Sighting, State
from pyros1.node.watching.watch import MIN_STALL, Watch

from ...parts import context_of

QUICK = {"period": 0.02, "limit": 5.0}
SHORT = {"period": 0.02, "limit": 0.1}


class Heard:
    """Callbacks that keep what they are told: ``+reason`` and ``-reason``."""

    def __init__(self, collect: Any) -> None:
        self.news = collect()
        self.on_found = lambda sighting: self.news((sighting, threading.current_thread().name))
        self.on_lost = self.on_found

    def alive(self, count: int) -> list[bool]:
        return [sighting.alive for sighting, _ in self.news.wait(count)]

    @property
    def last(self) -> Any:
        return self.news.items[-1][0]


@pytest.fixture
def heard(collect: Any) -> Heard:
    return Heard(collect)


@pytest.fixture
def watcher(make_node: Any) -> Any:
    return make_node("watcher")


@pytest.fixture
def fake(fake_node: Any) -> Any:
    """A node that answers what the test says; process 7."""
    fake = fake_node("/x")
    fake.answers["getPid"] = [1, "", 7]
    fake.publish("/t")
    return fake


@pytest.fixture
def hang(fake: Any) -> Iterator[Callable[[], threading.Event]]:
    """Return a function that lets the fake node hang until the event is set: it accepts, but does not answer."""
    events: list[threading.Event] = []

    def begin() -> threading.Event:
        events.append(threading.Event())
        fake.answers["getPid"] = lambda _, event=events[-1]: [event.wait(60), "", 7]
        return events[-1]

    yield begin
    for event in events:
        event.set()


def test_a_node_that_ends_is_lost_and_found_when_it_is_back(make_node: Any, watcher: Any, heard: Heard) -> None:
    watched = make_node("x")
    with watcher.watch("x", heard.on_lost, heard.on_found, **QUICK) as watch:
        assert heard.alive(1) == [True]
        assert (watch.state, watch.alive, watch.last) == (State.FOUND, True, heard.last)
        assert (heard.last.name, heard.last.uri, heard.last.silent) == ("/x", watched.uri, 0.0)
        watched.shutdown()
        assert heard.alive(2) == [True, False]
        assert "its port is closed" in heard.last.reason and heard.last.silent < 5.0
        assert (watch.state, watch.alive) == (State.LOST, False)
        make_node("x")
        assert heard.alive(3) == [True, False, True]
        assert {thread for _, thread in heard.news.items} == {"watch of /x"}


def test_the_end_of_a_connection_is_noticed_before_the_next_question(
    make_node: Any, watcher: Any, heard: Heard
) -> None:
    watched = make_node("x")
    watcher.watch("/x", heard.on_lost, heard.on_found, period=600.0, limit=5.0)
    heard.news.wait(1)
    watched.shutdown()
    assert heard.alive(2) == [True, False]


def test_a_node_that_hangs_is_lost_after_the_limit(watcher: Any, fake: Any, hang: Any, heard: Heard) -> None:
    watcher.watch("/x", heard.on_lost, heard.on_found, **SHORT)
    heard.news.wait(1)
    event = hang()
    assert heard.alive(2) == [True, False]
    assert "did not answer within" in heard.last.reason and heard.last.silent >= 0.1
    fake.answers["getPid"] = [1, "", 7]
    event.set()
    assert heard.alive(3)[2] and heard.last.reason == "it answers again"


@pytest.mark.slow
def test_a_watcher_that_stood_still_itself_asks_again(watcher: Any, fake: Any, hang: Any, heard: Heard) -> None:
    watcher.watch("/x", heard.on_lost, heard.on_found, period=0.02, limit=1.5)
    heard.news.wait(1)
    event = hang()
    fake.calls.wait(len(fake.calls.items) + 1)
    context_of(watcher).loop.run(time.sleep, 1.5 + 1.5 * MIN_STALL)  # as if this process had been stopped
    fake.answers["getPid"] = [1, "", 7]
    event.set()
    fake.calls.wait(len(fake.calls.items) + 5)
    assert heard.alive(1) == [True]


class Scene:
    """A watch whose clock, node and master are the test's: it watches ``/x`` at ``http://x:1/``, which was found."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, limit: float) -> None:
        self.now = 0.0
        self.asked: list[tuple[str, Callable[..., None], float]] = []
        self.sightings: list[Sighting] = []
        self.retries: list[Callable[[], None]] = []
        self.num_lookups = 0
        monkeypatch.setattr("pyros1.node.watching.watch.monotonic", lambda: self.now)
        loop: Any = SimpleNamespace(call_later=lambda _delay, function: self.retries.append(function))
        lookups: Any = SimpleNamespace(look_up=self._look_up)
        rpc: Any = SimpleNamespace(call=self._call)
        self.watch = Watch(loop, rpc, lookups, "/me", "/x", 60.0, limit, self.sightings.append, print)
        self.watch.poll()
        self.answer("getPid", [1, "", 7])
        self.answer("getName", [1, "", "/x"])

    def _look_up(self, _name: str, done: Callable[[str], None]) -> None:
        self.num_lookups += 1
        done("http://x:1/")

    def _call(self, _uri: str, method: str, _params: object, done: Callable[..., None], timeout: float) -> None:
        self.asked.append((method, done, timeout))

    def answer(self, method: str, reply: object, error: Exception | None = None) -> None:
        assert self.asked[-1][0] == method
        self.asked[-1][1](reply, error)


def test_after_standing_still_a_node_that_has_just_failed_gets_the_whole_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its failure is older than the limit only because this process was suspended."""
    limit = 1.0
    scene = Scene(monkeypatch, limit)
    scene.now = 10.0
    scene.watch.poll()
    scene.answer("getPid", None, UnreachableError("the connection was reset"))
    scene.now = 10.1
    scene.retries.pop()()
    scene.now = 10.1 + 5 * limit + MIN_STALL
    scene.answer("getPid", None, DeadlineError("did not answer"))
    assert scene.asked[-1][2] == limit and [sighting.alive for sighting in scene.sightings] == [True]


def test_a_node_that_misses_one_deadline_is_lost_and_its_name_looked_up_at_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Another node of this name may be running already."""
    scene = Scene(monkeypatch, limit=1.0)
    scene.now = 10.0
    scene.watch.poll()
    scene.now = 11.0
    num_lookups = scene.num_lookups
    scene.answer("getPid", None, DeadlineError("did not answer"))
    assert [sighting.alive for sighting in scene.sightings] == [True, False]
    assert scene.num_lookups == num_lookups + 1


def test_a_second_node_of_the_name_is_a_replacement(watcher: Any, fake: Any, fake_node: Any, heard: Heard) -> None:
    watcher.watch("/x", heard.on_lost, heard.on_found, **QUICK)
    heard.news.wait(1)
    other = fake_node("/x")
    other.answers["getPid"] = [1, "", 8]
    other.publish("/t")
    assert heard.alive(3) == [True, False, True]
    (lost, _), (back, _) = heard.news.items[1:]
    assert (lost.uri, lost.pid) == (fake.uri, 7) and "replaced by a node of the same name" in lost.reason
    assert (back.uri, back.pid) == (other.uri, 8)


def test_another_process_in_its_place(watcher: Any, fake: Any, heard: Heard) -> None:
    """Ports are used again: what answers there may be another node."""
    watcher.watch("/x", heard.on_lost, heard.on_found, **QUICK)
    heard.news.wait(1)
    fake.answers["getPid"] = [1, "", 8]
    assert heard.alive(3) == [True, False, True]
    fake.answers["getName"] = [1, "", "/y"]
    fake.answers["getPid"] = [1, "", 9]
    assert heard.alive(4) == [True, False, True, False] and "/y answers in its place" in heard.last.reason
    fake.answers["getPid"] = [1, "", 8]
    assert heard.alive(5)[4], "the one that was found before"


def test_what_is_listed_but_dead_or_another_node_is_not_found(watcher: Any, fake: Any, until: Any) -> None:
    fake.answers["getName"] = [1, "", "/y"]
    watch = watcher.watch("/x", **QUICK)
    fake.calls.until(lambda calls: [name for name, _ in calls].count("getName") > 3)
    assert watch.state is State.UNSEEN


def test_a_node_without_these_methods_is_there(watcher: Any, fake: Any, heard: Heard) -> None:
    def fault(*_: Any) -> Any:
        raise LookupError("no such method")  # answered with a fault

    fake.answers["getPid"] = fake.answers["getName"] = fault
    watcher.watch("/x", heard.on_lost, heard.on_found, **QUICK)
    assert heard.alive(1) == [True] and heard.last.pid is None
    fake.calls.wait(len(fake.calls.items) + 5)
    assert len(heard.news.items) == 1


def test_a_name_that_never_was_is_unseen_until_it_comes(make_node: Any, watcher: Any, heard: Heard) -> None:
    with watcher.watch("/x", heard.on_lost, heard.on_found, **QUICK) as watch:
        heard.news.until(bool, timeout=0.2)
        assert watch.state is State.UNSEEN and watch.last is None and not heard.news.items
        make_node("x")
        assert heard.alive(1) == [True]


@pytest.mark.slow
def test_a_master_that_is_silent_gone_or_new_changes_nothing(
    watcher: Any, master: Master, fake: Any, heard: Heard
) -> None:
    watcher.watch("/x", heard.on_lost, heard.on_found, period=0.02, limit=1.0)
    heard.news.wait(1)
    port = master.port
    master.stop()
    with socket.create_server(("127.0.0.1", port)):  # accepts, and answers nothing
        fake.calls.wait(len(fake.calls.items) + 75)  # longer than the limit
    fake.calls.wait(len(fake.calls.items) + 75)
    new = Master(port=port, bind_host="127.0.0.1")
    new.start()
    try:
        fake.calls.wait(len(fake.calls.items) + 10)
        assert heard.alive(1) == [True]
    finally:
        watcher.shutdown()
        new.stop()


def test_callbacks_of_a_node_that_spins_wait_for_it(make_node: Any, fake: Any, until: Any) -> None:
    node = make_node("watcher", callbacks="spin")
    told: list[Any] = []
    watch = node.watch("/x", on_found=lambda sighting: told.append(threading.current_thread()), **QUICK)
    until(lambda: watch.alive)
    assert told == []
    while not told:
        node.spin_once(5.0)
    assert told == [threading.current_thread()]


def test_a_closed_watch_of_a_node_that_spins_calls_nothing_that_waits(make_node: Any, fake: Any, until: Any) -> None:
    node = make_node("watcher", callbacks="spin")
    told: list[Any] = []
    watch, other = (node.watch("/x", on_found=told.append, **QUICK) for _ in range(2))
    until(lambda: watch.alive and other.alive)
    watch.close()
    while not told:
        node.spin_once(5.0)
    node.spin_once(0.0)
    assert len(told) == 1


def test_news_for_a_node_that_never_spins_are_bounded(make_node: Any, fake: Any, until: Any) -> None:
    node = make_node("watcher", callbacks="spin")
    told: list[Any] = []
    pids = iter(range(1_000_000))
    fake.answers["getPid"] = lambda _: [1, "", next(pids)]
    watch = node.watch("/x", told.append, told.append, period=0.001, limit=5.0)
    until(lambda: next(pids) > 500)
    watch.last = None
    until(lambda: watch.last)
    last = watch.last
    count = 0
    while ran := node.spin_once():
        count += ran
    assert 0 < len(told) <= 110 and count <= 110
    assert told[-1].pid >= last.pid - 1, "the newest are kept"


def test_a_callback_that_raises_hears_more(make_node: Any, watcher: Any, watch_log: Any, collect: Any) -> None:
    log, lost = watch_log(watcher), collect()

    def fail(sighting: Any) -> None:
        lost(sighting)
        raise SystemExit if sighting.alive else ZeroDivisionError

    watcher.watch("/x", fail, fail, **QUICK)
    node = make_node("x")
    log.saw("watch of /x: sys.exit() ends a program only from its main thread")
    node.shutdown()
    log.saw("bad function for watch of /x", "ZeroDivisionError")
    make_node("x")
    assert [sighting.alive for sighting in lost.wait(3)] == [True, False, True]


def test_a_node_may_watch_itself(watcher: Any, heard: Heard) -> None:
    watcher.watch("watcher", heard.on_lost, heard.on_found, **QUICK)
    assert heard.alive(1) == [True]
    watcher.shutdown()
    assert heard.alive(1) == [True], "at its end there is nobody to tell"


def test_a_closed_watch_tells_nothing(make_node: Any, watcher: Any, heard: Heard, until: Any) -> None:
    node = make_node("x")
    first = watcher.watch("/x", heard.on_lost, heard.on_found, **QUICK)
    second_heard = Heard(type(heard.news))
    second = watcher.watch("/x", second_heard.on_lost, second_heard.on_found, **QUICK)
    heard.news.wait(1)
    second_heard.news.wait(1)
    first.close()
    first.close()
    node.shutdown()
    assert second_heard.alive(2) == [True, False] and heard.alive(1) == [True]
    assert first.closed and not second.closed
    second.close()
    watcher.watch("/x", **QUICK).close()
    third = watcher.watch("/x", **QUICK)  # those of one period share turns, which have ended and begin again
    make_node("x")
    until(lambda: third.alive)


def test_a_callback_may_end_the_node_and_watches(make_node: Any, collect: Any) -> None:
    done = collect()
    for number in range(3):
        watcher, node = make_node(f"watcher{number}"), make_node("x")

        def on_lost(sighting: Any, watcher: Any = watcher) -> None:
            watcher.shutdown()
            done(watcher.ok())

        found = collect()
        watcher.watch("/x", on_lost, found, **QUICK)
        watcher.watch("/x", on_found=found, **QUICK)
        found.wait(2)
        node.shutdown()
    assert done.wait(3) == [False] * 3
    with pytest.raises(NodeShutdownError):
        watcher.watch("/x")


def test_losses_finds_and_ends_in_any_order(make_node: Any) -> None:
    """Whatever comes together: no error, no thread that stays, nothing told after the end."""
    for seed in range(4):
        choose = random.Random(seed)
        watcher = make_node(f"watcher{seed}", callbacks=choose.choice(("inline", "spin")))
        late: list[Any] = []
        over = threading.Event()

        def notify(sighting: Any, over: threading.Event = over, late: list[Any] = late) -> None:
            if over.is_set():
                late.append(sighting)

        watches = [watcher.watch("/x", notify, notify, period=0.002, limit=0.05) for _ in range(3)]
        for _ in range(choose.randrange(4)):
            node = make_node("x")
            watcher.spin_once(choose.random() * 0.02)
            choose.choice(watches).close()
            node.shutdown()
        watcher.shutdown()
        over.set()
        watcher.spin_once()
        assert not late


@pytest.mark.parametrize(
    ("arguments", "options", "error"),
    [
        ((), {"name": ""}, "name"),
        ((5,), {}, "watch: the name must be a str"),
        (("/x", 5), {}, "watch: on_lost must be a function"),
        (("/x", None, 5), {}, "watch: on_found must be a function"),
        (("/x",), {"period": 0}, "watch: period must be above 0"),
        (("/x",), {"limit": float("inf")}, "watch: limit must be above 0"),
        (("/x",), {"limit": "1"}, "watch: limit must be a number of s"),
        (("/a b",), {}, "a b"),
    ],
)
def test_wrong_arguments(watcher: Any, arguments: Any, options: Any, error: str) -> None:
    with pytest.raises((TypeError, ValueError), match=error):
        watcher.watch(*arguments, **options)
