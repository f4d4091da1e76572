"""How much may be on its way: over networks that are simulated here, and with sites that do not answer."""

from __future__ import annotations

import heapq
from itertools import count

import pytest

from pyros1.bridge.transport.pacing import FIRST_WINDOW, IGNORE_TIME, LARGEST_WINDOW, PATIENCE, SMALLEST_WINDOW, Pacing


def transfer(bandwidth: float, delay: float, size: int, duration: float = 30.0) -> tuple[float, float]:
    """Send packets as fast as pacing allows.

    Args:
        bandwidth: bytes per second of the network, which queues everything.
        delay: seconds on the way, besides the queue.
        size: of each packet.

    Returns:
        The part of the bandwidth that was used, and the longest time in the queue in the second half.
    """
    pacing, now, free_at, carried, longest = Pacing(), 0.0, 0.0, 0, 0.0
    answers: list[tuple[float, int, int]] = []
    order = count()
    while now < duration:
        if pacing.may_send(now):
            free_at = max(free_at, now) + size / bandwidth
            carried += size
            if now > duration / 2:
                longest = max(longest, free_at - now)
            number = pacing.on_sent(size, now)
            if number is not None:
                pacing.on_probe_reply(number, ["base"], now)
                heapq.heappush(answers, (free_at + 2 * delay, next(order), number))
        else:
            now += 0.001
        while answers and answers[0][0] <= now:
            pacing.on_answer("base", heapq.heappop(answers)[2], now)
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
    assert longest <= 0.3 + 2 * size / bandwidth, f"packets wait for {longest:.2f} s"


def test_a_window_of_bytes() -> None:
    pacing = Pacing()
    numbers = []
    while pacing.may_send(0.0):
        number = pacing.on_sent(8_192, 0.0)
        if number is not None:
            pacing.on_probe_reply(number, ["base"], 0.0)
            numbers.append(number)
    assert numbers == [1, 2, 3, 4]
    pacing.on_answer("stranger", 1, 0.01)
    assert not pacing.may_send(0.01)
    pacing.on_answer("base", 1, 0.01)
    assert pacing.may_send(0.01) and pacing.window == FIRST_WINDOW * 5 / 4
    pacing.on_answer("base", 4, 5.0)  # it has taken long
    assert SMALLEST_WINDOW <= pacing.window < FIRST_WINDOW
    pacing.on_answer("base", 2, 5.0)  # overtaken by a later answer
    pacing.on_answer("base", 99, 5.0)


def test_a_packet_larger_than_the_window() -> None:
    pacing = Pacing()
    assert pacing.may_send(0.0)
    number = pacing.on_sent(LARGEST_WINDOW * 2, 0.0)
    assert number == 1
    pacing.on_probe_reply(number, ["base"], 0.0)
    assert not pacing.may_send(0.1)
    pacing.on_answer("base", number, 0.1)
    assert pacing.may_send(0.1)


def test_the_slowest_of_several_sites_counts() -> None:
    pacing = Pacing()
    number = pacing.on_sent(FIRST_WINDOW, 0.0)
    assert number is not None
    pacing.on_probe_reply(number, ["base", "blue"], 0.0)
    pacing.on_answer("base", number, 0.1)
    assert not pacing.may_send(0.1)
    pacing.on_answer("blue", number, 0.2)
    assert pacing.may_send(0.2)


def test_a_site_that_does_not_answer_slows_nobody_down_for_long() -> None:
    pacing = Pacing()
    number = pacing.on_sent(FIRST_WINDOW, 0.0)
    assert number is not None
    pacing.on_probe_reply(number, ["base", "liar"], 0.0)
    pacing.on_answer("base", number, 0.1)
    assert not pacing.may_send(PATIENCE) and pacing.may_send(PATIENCE + 0.1)
    now = PATIENCE + 0.2
    number = pacing.on_sent(FIRST_WINDOW, now)
    assert number is not None
    pacing.on_probe_reply(number, ["base", "liar"], now)
    pacing.on_answer("base", number, now + 0.1)
    assert pacing.may_send(now + 0.1)
    later = now + IGNORE_TIME
    number = pacing.on_sent(int(pacing.window) + 1, later)
    assert number is not None
    pacing.on_probe_reply(number, ["liar"], later)
    assert not pacing.may_send(later)


def test_probes_for_nobody() -> None:
    pacing = Pacing()
    number = pacing.on_sent(FIRST_WINDOW, 0.0)
    assert number is not None and not pacing.may_send(0.0)
    pacing.on_probe_reply(number, [], 0.0)
    pacing.on_probe_reply(77, [], 0.0)
    assert pacing.may_send(0.0)
