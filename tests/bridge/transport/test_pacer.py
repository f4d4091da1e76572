"""How much may be on its way: over networks that are simulated here, and with sites that do not answer."""

from __future__ import annotations

import heapq
from itertools import count

import pytest

from pyros1.bridge.transport.pacer import FIRST_WINDOW, LARGEST_WINDOW, PATIENCE, SLOW_COUNT, SMALLEST_WINDOW, Pacer

TRIP = 0.02
"""A round trip of small packets in seconds."""


def transfer(bandwidth: float, delay: float, size: int, duration: float = 30.0) -> tuple[float, float]:
    """Send packets as fast as pacer allows.

    Args:
        bandwidth: bytes per second of the network, which queues everything.
        delay: seconds on the way, besides the queue.
        size: of each packet.

    Returns:
        The part of the bandwidth that was used, and the longest time in the queue in the second half.
    """
    pacer, now, free_at, carried, longest = Pacer(), 0.0, 0.0, 0, 0.0
    answers: list[tuple[float, int, int]] = []
    order = count()
    while now < duration:
        if pacer.may_send(now):
            free_at = max(free_at, now) + size / bandwidth
            carried += size
            if now > duration / 2:
                longest = max(longest, free_at - now)
            number = pacer.on_sent(size, now)
            if number is not None:
                pacer.on_probe_sent(number, {"base": 2 * delay})
                heapq.heappush(answers, (free_at + 2 * delay, next(order), number))
        else:
            now += 0.001
        while answers and answers[0][0] <= now:
            pacer.on_answer("base", heapq.heappop(answers)[2], now)
    return carried / bandwidth / duration, longest


@pytest.mark.parametrize(
    ("bandwidth", "delay", "size"),
    [
        (125_000, 0.01, 5_000),  # 1 Mbit/s
        (125_000, 0.15, 5_000),
        (1_250_000, 0.05, 20_000),
        (12_500_000, 0.01, 100_000),
        (12_500_000, 0.15, 100_000),
    ],
)
def test_a_network_is_used_and_not_filled(bandwidth: float, delay: float, size: int) -> None:
    used, longest = transfer(bandwidth, delay, size)
    assert 0.75 <= used <= 1.1, f"{used:.2f} of the bandwidth is used"
    assert longest <= 0.3 + 3 * delay + 2 * size / bandwidth, f"packets wait for {longest:.2f} s"


def test_a_window_of_bytes() -> None:
    pacer = Pacer()
    numbers = []
    while pacer.may_send(0.0):
        number = pacer.on_sent(8_192, 0.0)
        if number is not None:
            pacer.on_probe_sent(number, {"base": TRIP})
            numbers.append(number)
    assert numbers == [1, 2, 3, 4]
    pacer.on_answer("stranger", 1, 0.01)
    assert not pacer.may_send(0.01)
    pacer.on_answer("base", 1, 0.01)
    assert pacer.may_send(0.01) and pacer.window == FIRST_WINDOW * 9 / 8
    pacer.on_answer("base", 4, 5.0)  # it has taken long
    assert SMALLEST_WINDOW <= pacer.window < FIRST_WINDOW
    pacer.on_answer("base", 2, 5.0)  # overtaken by a later answer
    pacer.on_answer("base", 99, 5.0)


def test_a_packet_larger_than_the_window() -> None:
    pacer = Pacer()
    assert pacer.may_send(0.0)
    number = pacer.on_sent(LARGEST_WINDOW * 2, 0.0)
    assert number == 1
    pacer.on_probe_sent(number, {"base": TRIP})
    assert not pacer.may_send(0.1)
    pacer.on_answer("base", number, 0.1)
    assert pacer.may_send(0.1)


def test_the_slowest_of_several_sites_counts() -> None:
    pacer = Pacer()
    number = pacer.on_sent(FIRST_WINDOW, 0.0)
    assert number is not None
    pacer.on_probe_sent(number, {"base": TRIP, "blue": TRIP})
    pacer.on_answer("base", number, 0.1)
    assert not pacer.may_send(0.1)
    pacer.on_answer("blue", number, 0.2)
    assert pacer.may_send(0.2)


def ask(pacer: Pacer, now: float, answers: dict[str, float | None]) -> float:
    """Send as much as the window allows, let sites answer after some time, or never, and return when that is over."""
    number = pacer.on_sent(int(pacer.window) + 1, now)
    assert number is not None
    pacer.on_probe_sent(number, dict.fromkeys(answers, TRIP))
    for site, took in answers.items():
        if took is not None:
            pacer.on_answer(site, number, now + took)
    end = now + max(PATIENCE + 0.1 if took is None else took for took in answers.values())
    assert pacer.may_send(end)
    return end


def test_a_site_that_holds_up_others_is_slow() -> None:
    pacer, now = Pacer(), 0.0
    now = ask(pacer, now, {"base": 0.02, "blue": 0.02})
    for _ in range(SLOW_COUNT):
        assert pacer.pop_slow() == []
        now = ask(pacer, now, {"base": 0.02, "blue": 1.0})
        now = ask(pacer, now, {"base": 0.02, "blue": 0.02})  # the smaller window suits it
    assert pacer.pop_slow() == ["blue"] and pacer.pop_slow() == []


def test_a_site_that_does_not_answer_is_slow() -> None:
    pacer, now = Pacer(), 0.0
    for _ in range(SLOW_COUNT):
        assert pacer.pop_slow() == []
        now = ask(pacer, now, {"base": 0.1, "liar": None})
    assert pacer.pop_slow() == ["liar"]
    number = pacer.on_sent(LARGEST_WINDOW, now)
    assert number is not None
    pacer.on_probe_sent(number, {"liar": TRIP})
    assert not pacer.may_send(now)
    pacer.remove("liar")
    assert pacer.may_send(now)


@pytest.mark.parametrize("took", [None, 1.0])
def test_sites_that_are_slow_together_are_not_slow(took: float | None) -> None:
    """Their way has a part in common, which would have to carry everything twice."""
    pacer, now = Pacer(), 0.0
    for _ in range(10):
        now = ask(pacer, now, {"base": 0.02, "blue": 0.02})
        now = ask(pacer, now, {"base": took, "blue": took})
        assert pacer.pop_slow() == []


def test_a_single_site_holds_up_nobody() -> None:
    pacer, now = Pacer(), 0.0
    for took in (0.02, 1.0, None, 1.0, None, 1.0):
        now = ask(pacer, now, {"base": took})
    assert pacer.pop_slow() == [] and pacer.window == SMALLEST_WINDOW


def test_old_delays_do_not_count() -> None:
    pacer, now = Pacer(), 0.0
    for _ in range(10):
        now = ask(pacer, now, {"base": 0.02, "blue": 0.02})
        now = ask(pacer, now, {"base": 0.02, "blue": 1.0}) + 10.0
    assert pacer.pop_slow() == []


def windows_after(*times: float) -> list[float]:
    """Return the window after each of some answers; the shortest round trip of small packets is 0.2 s."""
    pacer, windows, now = Pacer(), [], 0.0
    for took in times:
        number = pacer.on_sent(int(pacer.window) + 1, now)
        assert number is not None
        pacer.on_probe_sent(number, {"base": 0.2})
        now += took
        pacer.on_answer("base", number, now)
        windows.append(pacer.window)
    return windows


def test_a_packet_that_is_sent_again_is_no_queue() -> None:
    first, again, twice, more, queue, stays = windows_after(0.3, 0.5, 0.57, 0.85, 0.3, 0.91)[:6]
    assert first < again < twice, "another round trip, and a little"
    assert twice == more < queue, "two more, once"
    assert stays == queue / 2, "such a delay is more than that"


def test_a_delay_that_stays_is_a_queue() -> None:
    first, once, twice = windows_after(0.3, 0.7, 0.7)
    assert once == first and twice == first / 2


def test_a_way_that_becomes_longer() -> None:
    windows = windows_after(0.01, *[1.0] * 20)
    assert SMALLEST_WINDOW in windows and windows[-1] > FIRST_WINDOW


def test_one_delay_shrinks_the_window_once() -> None:
    pacer = Pacer()
    ask(pacer, 0.0, {"base": 0.01})
    window = pacer.window
    numbers = []
    while pacer.may_send(1.0):
        if (number := pacer.on_sent(8_192, 1.0)) is not None:
            pacer.on_probe_sent(number, {"base": TRIP})
            numbers.append(number)
    assert len(numbers) > 2
    for number in numbers:
        pacer.on_answer("base", number, 1.9)
    assert pacer.window == window / 2


def test_a_window_that_is_not_used_does_not_grow() -> None:
    pacer = Pacer()
    for step in range(100):
        if (number := pacer.on_sent(5_000, step)) is not None:
            pacer.on_probe_sent(number, {"base": TRIP})
            pacer.on_answer("base", number, step + 0.01)
    assert pacer.window == FIRST_WINDOW


def steady(size: int, rate: float, took: float, seconds: int = 30) -> tuple[Pacer, float]:
    """Send packets at a steady rate, with answers after some time; return how many there were for each probe."""
    pacer, answers, probes = Pacer(), [(float("inf"), 0)], 0
    for step in range(int(seconds * rate)):
        now = step / rate
        while answers[0][0] <= now:
            pacer.on_answer("base", answers.pop(0)[1], now)
        if not pacer.may_send(now):
            assert now < 2, "a packet has to wait although the window has had time to grow"
            continue
        if (number := pacer.on_sent(size, now)) is not None:
            pacer.on_probe_sent(number, {"base": took})
            answers.insert(-1, (now + took, number))
            probes += 1
    return pacer, seconds * rate / probes


@pytest.mark.parametrize(("size", "rate", "at_least"), [(6_000, 100, 12), (6_000, 500, 60), (100_000, 30, 4)])
def test_there_are_few_probes_where_all_is_confirmed_at_once(size: int, rate: float, at_least: float) -> None:
    """They cost as much as messages."""
    pacer, packets_per_probe = steady(size, rate, 0.002)
    assert packets_per_probe >= at_least and pacer.is_calm
    assert pacer.window <= max(4 * FIRST_WINDOW, 0.5 * size * rate), "no more than half a second of what is sent"


def until_probe(pacer: Pacer, now: float) -> tuple[int, int]:
    """Send until there is a probe; return its number, and how many bytes that took."""
    sent = 1_000
    while (number := pacer.on_sent(1_000, now)) is None:
        sent += 1_000
    pacer.on_probe_sent(number, {"base": 0.002})
    return number, sent


def test_probes_are_frequent_where_much_is_on_its_way() -> None:
    pacer, _ = steady(6_000, 100, 0.002)
    number, _ = until_probe(pacer, 30.0)
    pacer.on_answer("base", number, 30.002)
    number, sent = until_probe(pacer, 30.01)
    assert pacer.window / 4 + 1_000 < sent <= pacer.window / 2 + 1_000
    until_probe(pacer, 30.01)
    pacer.on_answer("base", number, 30.02)
    assert not pacer.is_calm
    assert until_probe(pacer, 30.02)[1] <= pacer.window / 4 + 1_000


@pytest.mark.parametrize(("trip", "took"), [(0.002, 0.5), (0.3, 0.8)])
def test_a_late_answer_ends_the_calm(trip: float, took: float) -> None:
    """Also one that is perhaps late only since a packet was lost."""
    pacer, _ = steady(6_000, 100, 0.002)
    number, _ = until_probe(pacer, 31.0)
    assert pacer.is_calm
    pacer.on_probe_sent(number, {"base": trip})
    pacer.on_answer("base", number, 31.0 + took)
    assert not pacer.is_calm and pacer.unconfirmed_bytes == 0


def test_probes_for_nobody() -> None:
    pacer = Pacer()
    number = pacer.on_sent(FIRST_WINDOW, 0.0)
    assert number is not None and not pacer.may_send(0.0)
    pacer.on_probe_sent(number, {})
    pacer.on_probe_sent(77, {})
    assert pacer.may_send(0.0)


def test_delays_of_all_forgive_those_of_one() -> None:
    pacer, now = Pacer(), 0.0
    for blue, base in ((1.0, 0.02), (1.0, 0.02), (1.0, 1.0), (1.0, 0.02), (1.0, 0.02)):
        now = ask(pacer, now, {"base": 0.02, "blue": 0.02})
        now = ask(pacer, now, {"base": base, "blue": blue})
    assert pacer.pop_slow() == []


def test_the_window_grows_fast_again_without_the_slow_site() -> None:
    pacer, now = Pacer(), 0.0
    for _ in range(SLOW_COUNT):
        now = ask(pacer, now, {"base": 0.02, "blue": 0.02})
        now = ask(pacer, now, {"base": 0.02, "blue": 1.0})
    pacer.remove("blue")
    before = pacer.window
    ask(pacer, now, {"base": 0.02})
    assert pacer.window > 1.9 * before
