"""When another site counts as present, and when it is lost."""

from __future__ import annotations

from itertools import count
from typing import NamedTuple

import pytest

from pyros1.bridge.exchange.peer import FORGET_DELAY, HEARD_DELAY, MIN_PERIOD, Change, Peer, State
from pyros1.bridge.protocol.packets import Heartbeat
from pyros1.bridge.rules.rules import LOSS_DELAY

RED, BLUE = 11, 22
HEARTBEAT_PERIOD = LOSS_DELAY / 5


class Sent(NamedTuple):
    """A heartbeat on its way: from and to which epoch."""

    epoch: int
    to_epoch: int
    heartbeat: Heartbeat


def heartbeat(peer: Peer, own_epoch: int, now: float) -> Sent:
    to_epoch, made = peer.make_heartbeat(now, 1, 2, (3, 4), {})
    return Sent(own_epoch, to_epoch, made)


def meet(now: float = 0.0) -> tuple[Peer, Peer]:
    """Return what red knows of blue, and blue of red, after both have answered."""
    of_blue, of_red = Peer("blue", RED, count(1), now), Peer("red", BLUE, count(1), now)
    of_blue.hear(BLUE, now)
    first = heartbeat(of_blue, RED, now)
    assert of_red.on_heartbeat(*first, now) is Change.NONE and of_red.answer_due
    second = heartbeat(of_red, BLUE, now)
    assert of_blue.on_heartbeat(*second, now) is Change.STARTED
    third = heartbeat(of_blue, RED, now)
    assert of_red.on_heartbeat(*third, now) is Change.STARTED
    return of_blue, of_red


def test_both_are_present_after_three_heartbeats() -> None:
    of_blue, of_red = meet()
    assert of_blue.is_present and of_red.is_present
    assert (of_blue.epoch, of_red.epoch) == (BLUE, RED)
    assert of_red.is_current(RED, BLUE) and of_red.is_current(RED, 0)
    assert not of_red.is_current(RED + 1, BLUE) and not of_red.is_current(RED, BLUE + 1)
    assert (of_red.offer_wanted, of_red.request_wanted, of_red.offer_seen, of_red.request_seen) == (1, 2, 3, 4)


def test_recorded_packets_prove_nothing() -> None:
    of_blue, of_red = meet()
    recorded = heartbeat(of_red, BLUE, 0.5)
    later = Peer("blue", RED, count(1), 1.0)  # red's machine has forgotten blue
    later.hear(BLUE, 1.0)
    assert later.on_heartbeat(*recorded, 1.0) is Change.NONE and later.state is State.HEARD
    # In another run of red, even the numbers may be right.
    again = Peer("blue", RED + 1, count(1), 1.0)
    for _ in range(5):
        heartbeat(again, RED + 1, 1.0)
    assert again.on_heartbeat(*recorded, 1.0) is Change.NONE and again.state is State.HEARD
    assert of_blue.is_present


def test_a_new_run_takes_over_only_when_it_answers() -> None:
    of_blue, _ = meet()
    restarted = Peer("red", BLUE + 1, count(1), 2.0)
    of_blue.hear(BLUE + 1, 2.0)
    assert of_blue.is_current(BLUE, RED)
    question = heartbeat(of_blue, RED, 2.0)
    assert question.to_epoch == BLUE + 1
    restarted.on_heartbeat(*question, 2.0)
    assert of_blue.on_heartbeat(*heartbeat(restarted, BLUE + 1, 2.0), 2.0) is Change.STARTED
    assert of_blue.is_current(BLUE + 1, RED) and not of_blue.is_current(BLUE, RED)


def test_packets_of_an_old_run_do_not_disturb() -> None:
    of_blue, of_red = meet()
    for number in range(20):
        now = 1.0 + number
        of_blue.hear(BLUE - 1, now)  # a packet that was delayed for long
        assert of_red.on_heartbeat(*heartbeat(of_blue, RED, now), now) is Change.NONE
        of_blue.on_heartbeat(*heartbeat(of_red, BLUE, now + 0.1), now + 0.1)
        of_red.on_heartbeat(*heartbeat(of_blue, RED, now + 0.2), now + 0.2)
        assert not of_blue.tick(now) and not of_red.tick(now)
    assert of_blue.is_present and of_blue.epoch == BLUE and of_red.is_present


def test_repeated_and_overtaken_heartbeats_change_nothing() -> None:
    of_blue, of_red = meet()
    first, second = heartbeat(of_red, BLUE, 1.0), heartbeat(of_red, BLUE, 1.5)
    of_blue.on_heartbeat(*second, 2.0)
    for late in (first, second):
        changed = late.heartbeat._replace(offer_seen=99)
        assert of_blue.on_heartbeat(late.epoch, late.to_epoch, changed, 2.0) is Change.OUTDATED
    assert of_blue.offer_seen == 3


def test_a_site_is_lost_and_returns() -> None:
    of_blue, of_red = meet()
    assert not of_blue.tick(LOSS_DELAY - 0.1) and of_blue.tick(LOSS_DELAY) and not of_blue.tick(LOSS_DELAY + 1)
    assert of_blue.state is State.LOST and not of_blue.is_current(BLUE, RED)
    now = LOSS_DELAY + 2
    old = heartbeat(of_red, BLUE, now)  # answers a heartbeat of the time before
    assert of_blue.on_heartbeat(*old, now) is Change.NONE and of_blue.state is State.LOST
    of_red.on_heartbeat(*heartbeat(of_blue, RED, now), now)
    assert of_blue.on_heartbeat(*heartbeat(of_red, BLUE, now), now) is Change.RETURNED
    assert of_blue.is_present


def test_a_site_is_forgotten() -> None:
    of_blue, _ = meet()
    of_blue.tick(LOSS_DELAY)
    assert not of_blue.is_forgotten(FORGET_DELAY) and of_blue.is_forgotten(LOSS_DELAY + FORGET_DELAY)
    heard = Peer("green", RED, count(1), 0.0)
    heard.hear(5, 50.0)
    assert not heard.is_forgotten(49.0 + HEARD_DELAY) and heard.is_forgotten(50.0 + HEARD_DELAY)


def test_heartbeats_come_each_second_and_answers_not_more_often_than_necessary() -> None:
    peer = Peer("blue", RED, count(1), 0.0)
    assert peer.wants_heartbeat(0.0)
    heartbeat(peer, RED, 0.0)
    assert not peer.wants_heartbeat(0.5) and peer.wants_heartbeat(HEARTBEAT_PERIOD)
    peer.hear(BLUE, 0.05)  # packets that ask for an answer each time
    assert not peer.wants_heartbeat(0.05)
    peer.hear(BLUE, 0.15)
    assert peer.wants_heartbeat(0.15)


def test_a_slow_network_is_no_loss() -> None:
    """Heartbeats each second, 0.6 s each way, and one of ten is lost."""
    of_blue, of_red = meet()
    queue: list[tuple[float, Peer, Sent]] = []
    for step in range(400):
        now = step / 10
        for peer, other, epoch in ((of_blue, of_red, RED), (of_red, of_blue, BLUE)):
            if peer.wants_heartbeat(now):
                sent = heartbeat(peer, epoch, now)
                if sent.heartbeat.number % 10:
                    queue.append((now + 0.6, other, sent))
        for entry in [entry for entry in queue if entry[0] <= now]:
            queue.remove(entry)
            entry[1].on_heartbeat(*entry[2], now)
        assert not of_blue.tick(now) and not of_red.tick(now), now


def test_a_site_that_was_forgotten_comes_back() -> None:
    """Red forgets blue, which has only lost red: red's heartbeats are numbered on, so blue does not ignore them."""
    numbers = count(1)
    of_blue, of_red = Peer("blue", RED, numbers, 0.0), Peer("red", BLUE, count(1), 0.0)
    for _ in range(5):
        of_red.on_heartbeat(*heartbeat(of_blue, RED, 0.0), 0.0)
        of_blue.on_heartbeat(*heartbeat(of_red, BLUE, 0.0), 0.0)
    of_red.tick(LOSS_DELAY)
    later = Peer("blue", RED, numbers, 9.0)
    for _ in range(2):
        of_red.on_heartbeat(*heartbeat(later, RED, 9.0), 9.0)
        later.on_heartbeat(*heartbeat(of_red, BLUE, 9.0), 9.0)
    assert later.is_present and of_red.is_present


def test_heartbeats_come_as_often_as_one_of_both_wants() -> None:
    of_blue, of_red = Peer("blue", RED, count(1), 0.0, loss_delay=1.5), Peer("red", BLUE, count(1), 0.0)
    of_blue.hear(BLUE, 0.0)
    of_red.on_heartbeat(*heartbeat(of_blue, RED, 0.0), 0.0)
    of_blue.on_heartbeat(*heartbeat(of_red, BLUE, 0.0), 0.0)
    of_red.on_heartbeat(*heartbeat(of_blue, RED, 0.0), 0.0)
    heartbeat(of_red, BLUE, 0.0)
    assert not of_red.wants_heartbeat(0.29) and of_red.wants_heartbeat(0.31)
    assert not of_blue.wants_heartbeat(0.29) and of_blue.wants_heartbeat(0.31)
    assert not of_blue.tick(1.49) and of_blue.tick(1.51)
    assert not of_red.tick(4.99) and of_red.tick(5.01)
    assert not of_red.wants_heartbeat(0.9), "what a lost site wanted counts no longer"


@pytest.mark.parametrize("period", [0.0, -5.0])
def test_no_site_makes_another_one_send_without_end(period: float) -> None:
    _, of_red = meet()
    sent = heartbeat(of_red, BLUE, 0.0)
    answer = Heartbeat(9, 0.0, sent.heartbeat.number, 0.0, 1, 1, 1, 1, {}, period=period)
    of_red.on_heartbeat(RED, BLUE, answer, 0.0)
    assert not of_red.wants_heartbeat(MIN_PERIOD - 0.01) and of_red.wants_heartbeat(MIN_PERIOD + 0.01)


def test_two_runs_at_the_same_time() -> None:
    """Two bridges with one name."""
    of_blue, _ = meet()
    other = Peer("red", BLUE + 1, count(1), 0.0)
    of_blue.hear(BLUE + 1, 1.0)
    assert other.on_heartbeat(*heartbeat(of_blue, RED, 1.0), 1.0) is Change.NONE
    assert of_blue.on_heartbeat(*heartbeat(other, BLUE + 1, 1.1), 1.1) is Change.STARTED
    of_blue.hear(BLUE, 5.0)
    assert not of_blue.pop_namesake(), "that may be a packet on its way"
    of_blue.hear(BLUE, 12.0)
    assert of_blue.pop_namesake() and not of_blue.pop_namesake()
    of_blue.hear(BLUE, 13.0)
    assert not of_blue.pop_namesake()


def test_two_runs_in_turns() -> None:
    of_blue, of_red = meet()
    other = Peer("red", BLUE + 1, count(1), 0.0)
    of_blue.hear(BLUE + 1, 1.0)
    other.on_heartbeat(*heartbeat(of_blue, RED, 1.0), 1.0)
    assert of_blue.on_heartbeat(*heartbeat(other, BLUE + 1, 1.1), 1.1) is Change.STARTED
    of_blue.hear(BLUE, 2.0)
    of_red.on_heartbeat(*heartbeat(of_blue, RED, 2.0), 2.0)
    assert of_blue.on_heartbeat(*heartbeat(of_red, BLUE, 2.1), 2.1) is Change.STARTED and of_blue.pop_namesake()


def test_two_runs_of_which_none_can_become_present() -> None:
    """Two bridges with one name that start at the same time."""
    of_blue = Peer("blue", RED, count(1), 0.0)
    for number in range(3):
        assert not of_blue.pop_namesake()
        of_blue.hear(BLUE, 0.1 * number)
        of_blue.hear(BLUE + 1, 0.1 * number)
    of_blue.hear(BLUE, 1.0)
    assert of_blue.pop_namesake() and not of_blue.pop_namesake()


def test_a_site_that_starts_again_and_again_has_no_namesake() -> None:
    of_blue = Peer("blue", RED, count(1), 0.0)
    for number in range(100):
        of_blue.hear(BLUE + number, 0.1 * number)
    assert not of_blue.pop_namesake()
