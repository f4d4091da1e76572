"""clock: wall time, simulated time, rates and timers (P26-P32, O17).

Feature: simulated time -- `/use_sim_time`, `/clock`
"""

from __future__ import annotations

import gc
import threading
import time
import weakref
from typing import Any

import pytest

from pyros1.ground.errors import TimeMovedBackwardsError
from pyros1.ground.timing import Time
from pyros1.node.callback_queue import CallbackQueue
from pyros1.node.clock import Clock, Rate, Timer


@pytest.fixture
def stopping() -> threading.Event:
    return threading.Event()


class Simulation(Clock):
    """A simulated clock whose waits the test can see."""

    def __init__(self, stopping: threading.Event) -> None:
        super().__init__(stopping)
        self.use_simulated_time()
        self.waiting = threading.Semaphore(0)
        wait = self._ticked.wait_for

        def watched(ready: Any, timeout: float | None = None) -> bool:
            self.waiting.release()
            return wait(ready, timeout)

        self._ticked.wait_for = watched  # type: ignore[method-assign]

    def go(self, seconds: float) -> None:
        """Let the time come once somebody sleeps."""
        assert self.waiting.acquire(timeout=20)
        self.tick(Time.from_sec(seconds))


@pytest.fixture
def clock(stopping: threading.Event) -> Any:
    clock = Simulation(stopping)
    yield clock
    stopping.set()
    clock.wake()


# Wall time ------------------------------------------------------------------------------------------------------------


def test_wall_time(stopping: threading.Event) -> None:
    clock = Clock(stopping)
    before = time.time()
    now = clock.now()
    assert before - 1e-6 <= now.to_sec() <= time.time() + 1e-6
    start = time.monotonic()
    assert clock.sleep(0.02)
    assert time.monotonic() - start >= 0.019
    assert clock.sleep(0) and clock.sleep(-1)


def test_sleep_ends_with_the_node(stopping: threading.Event, in_thread: Any) -> None:
    sleeping = in_thread(Clock(stopping).sleep, 30.0)
    stopping.set()
    assert sleeping.join() is False
    assert Clock(stopping).sleep(0) is False


def test_rate_in_wall_time(stopping: threading.Event) -> None:
    rate = Rate(Clock(stopping), 100.0)
    start = time.monotonic()
    for _ in range(10):
        assert rate.sleep()
    assert time.monotonic() - start >= 0.099
    stopping.set()
    assert not rate.sleep()


@pytest.mark.parametrize("frequency", [0, -1, float("nan")])
def test_rates_are_positive(stopping: threading.Event, frequency: float) -> None:
    with pytest.raises(ValueError, match="above 0"):
        Rate(Clock(stopping), frequency)


# Simulated time -------------------------------------------------------------------------------------------------------


def test_time_is_zero_until_the_first_tick_p32(clock: Simulation) -> None:
    assert clock.now() == Time(0)
    clock.tick(Time(5))
    assert clock.now() == Time(5)


def test_sleep_follows_the_ticks_p29(clock: Simulation, in_thread: Any) -> None:
    sleeping = in_thread(clock.sleep, 1.0)
    clock.go(100.0)  # begins here, not at 0
    clock.go(100.5)
    clock.go(100.999)
    clock.go(101.0)
    assert sleeping.join() is True


def test_sleep_is_not_woken_by_wall_time(clock: Simulation, in_thread: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.node.clock.POLL_INTERVAL", 0.001)
    clock.tick(Time(1))
    sleeping = in_thread(clock.sleep, 0.001)
    for _ in range(50):
        assert clock.waiting.acquire(timeout=20)
    assert sleeping.thread.is_alive()
    clock.tick(Time(2))
    assert sleeping.join() is True


def test_time_that_jumps_back_ends_a_sleep_p29(clock: Simulation, in_thread: Any) -> None:
    clock.tick(Time(100))
    sleeping = in_thread(clock.sleep, 1.0)
    clock.go(100.5)
    clock.go(40.5)
    with pytest.raises(TimeMovedBackwardsError) as caught:
        sleeping.join()
    assert caught.value.jump == pytest.approx(-60.0)


def test_time_that_goes_back_a_little_does_not_end_a_sleep(clock: Simulation, in_thread: Any) -> None:
    """As when two publish /clock."""
    clock.tick(Time(10))
    sleeping = in_thread(clock.sleep, 1.0)
    for seconds in (10.5, 10.4, 10.9, 11.0):
        clock.go(seconds)
    sleeping.join()


def test_sleep_in_simulated_time_ends_with_the_node(
    clock: Simulation, in_thread: Any, stopping: threading.Event
) -> None:
    for start in (0, 5):
        clock.tick(Time(start))
        sleeping = in_thread(clock.sleep, 1.0)
        assert clock.waiting.acquire(timeout=20)
        stopping.set()
        clock.wake()
        assert sleeping.join() is False
        stopping.clear()


def test_a_node_that_ends_waits_for_ticks_only_while_they_come(
    clock: Simulation, in_thread: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.clock.TICK_TIMEOUT", 100)
    clock.tick(Time(100, 0))
    clock.ending = True
    sleep = in_thread(clock.sleep, 3.0)
    for seconds in (101, 102, 103):
        clock.go(seconds)
    assert sleep.join() is True
    monkeypatch.setattr("pyros1.node.clock.TICK_TIMEOUT", 0)
    assert in_thread(clock.sleep, 3.0).join() is False


def test_rate_in_simulated_time(clock: Simulation, in_thread: Any) -> None:
    clock.tick(Time(10))
    rate = Rate(clock, 2.0)
    cycle = in_thread(rate.sleep)
    clock.go(10.4)
    clock.go(10.5)
    assert cycle.join()
    clock.tick(Time.from_sec(10.9))
    assert rate.remaining() == pytest.approx(0.1)
    cycle = in_thread(rate.sleep)
    while not clock.waiting.acquire(timeout=0.01):
        pass
    clock.tick(Time(11))
    assert cycle.join()


def test_a_late_rate_begins_a_new_beat_p30(clock: Simulation) -> None:
    clock.tick(Time(10))
    rate = Rate(clock, 1.0)
    clock.tick(Time(20))
    assert rate.sleep()  # at once
    assert rate.remaining() == pytest.approx(1.0)


def test_a_rate_survives_a_jump_back(clock: Simulation, in_thread: Any) -> None:
    clock.tick(Time(1000))
    rate = Rate(clock, 1.0)
    clock.tick(Time(10))
    cycle = in_thread(rate.sleep)
    clock.go(11.0)
    assert cycle.join()
    assert rate.remaining() == pytest.approx(1.0)


# Timers ---------------------------------------------------------------------------------------------------------------


class NoLog:
    def __init__(self) -> None:
        self.texts: list[str] = []

    def exception(self, text: str, error: BaseException) -> None:
        self.texts.append(f"{text}: {error!r}")


def make_timer(
    clock: Clock, callback: Any, *, period: float = 0.01, oneshot: bool = False, queue: Any = None, log: Any = None
) -> Any:
    return Timer(clock, period, callback, oneshot, queue, log or NoLog())


def test_timer_p31(stopping: threading.Event, collect: Any) -> None:
    got = collect()
    timer = make_timer(Clock(stopping), got)
    first, second, *_ = got.wait(3)
    timer.shutdown()
    timer.join(5)
    assert first.last_expected is first.last_real is first.last_duration is None
    assert (second.last_expected, second.last_real) == (first.current_expected, first.current_real)
    assert second.last_duration >= 0
    assert (second.current_expected - first.current_expected).to_sec() == pytest.approx(0.01, abs=0.5)
    assert first.current_real >= first.current_expected - type(first.current_real - first.current_real)(0, 5_000_000)


def test_a_oneshot_timer_fires_once(stopping: threading.Event, collect: Any) -> None:
    got = collect()
    timer = make_timer(Clock(stopping), got, oneshot=True)
    timer.join(5)
    assert len(got.items) == 1


def test_a_long_timer_can_be_ended(stopping: threading.Event, collect: Any) -> None:
    got = collect()
    timer = make_timer(Clock(stopping), got, period=100.0)
    timer.shutdown()
    timer.join(5)
    assert not timer.alive and not got.items


def test_a_bad_timer_callback_is_called_again(stopping: threading.Event) -> None:
    called = threading.Semaphore(0)

    def bad(event: Any) -> None:
        called.release()
        raise RuntimeError("no")

    log = NoLog()
    timer = make_timer(Clock(stopping), bad, log=log)
    assert called.acquire(timeout=20) and called.acquire(timeout=20)
    timer.shutdown()
    timer.join(5)
    assert "RuntimeError('no')" in log.texts[0]


def test_a_timer_of_a_node_that_spins_queues_one_call_at_a_time(stopping: threading.Event, collect: Any) -> None:
    queue, got = CallbackQueue(), collect()
    timer = make_timer(Clock(stopping), got, period=0.001, queue=queue)
    assert queue.wait(5)
    Clock(stopping).sleep(0.02)
    assert len(queue) == 1 and not got.items
    queue.run_available()
    assert len(got.items) == 1
    assert queue.wait(5)
    timer.shutdown()
    queue.run_available()
    assert len(got.items) == 1, "not after its end"
    timer.join(5)


def test_a_timer_follows_simulated_time(clock: Simulation, collect: Any) -> None:
    got = collect()
    clock.tick(Time(10))
    timer = make_timer(clock, got, period=1.0)
    clock.go(11.0)
    got.wait(1)
    clock.go(12.0)
    got.wait(2)
    timer.shutdown()
    clock.go(13.0)
    timer.join(5)
    assert [event.current_expected for event in got.items] == [Time(11), Time(12)]
    assert [event.current_real for event in got.items] == [Time(11), Time(12)]


@pytest.mark.parametrize("period", [0, -1])
def test_periods_are_positive(stopping: threading.Event, period: float) -> None:
    with pytest.raises(ValueError, match="above 0"):
        make_timer(Clock(stopping), print, period=period)


# Nodes ----------------------------------------------------------------------------------------------------------------


def test_a_node_runs_on_simulated_time_o17(make_node: Any, in_thread: Any, until: Any) -> None:
    world = make_node("world")
    world.params["/use_sim_time"] = True
    node = make_node("node")
    publisher = world.advertise("/clock", "rosgraph_msgs/Clock", latch=True)
    assert publisher.wait_for_subscribers(timeout=20)
    assert node.now() == Time(0)
    assert world.now().secs > 1_000_000_000, "started before the parameter was set"
    publisher.publish(Time(1234, 5))
    until(lambda: node.now() == Time(1234, 5))
    sleeping = in_thread(node.sleep, 10.0)
    fired = threading.Event()
    timer = node.timer(5.0, lambda event: fired.set())
    for second in range(1235, 1300):
        publisher.publish(Time(second, 0))
        if fired.wait(0.01) and not sleeping.thread.is_alive():
            break
    assert sleeping.join() is True
    assert fired.is_set()
    timer.shutdown()


def test_a_node_that_spins_has_time_without_spinning(make_node: Any, until: Any) -> None:
    world = make_node("world")
    world.params["/use_sim_time"] = True
    publisher = world.advertise("/clock", "rosgraph_msgs/Clock")
    node = make_node("node", callbacks="spin")
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(Time(7))
    until(lambda: node.now() == Time(7))


@pytest.mark.slow
def test_a_node_forgets_timers_that_have_ended(make_node: Any) -> None:
    node = make_node("node")
    timers = []
    for _ in range(3):
        timer = node.timer(0.001, lambda event: None, oneshot=True)
        timer.join(5)
        assert not timer.alive
        timers.append(weakref.ref(timer))
    gc.collect()
    assert [made() is None for made in timers] == [True, True, False], "but for the one made last"


def test_node_timers_end_with_the_node(make_node: Any) -> None:
    node = make_node("node")
    fired = threading.Event()
    timer = node.timer(0.005, lambda event: fired.set())
    assert fired.wait(20)
    node.shutdown()
    assert not timer.alive
