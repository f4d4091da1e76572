"""sighting: what is known of a watched node."""

from __future__ import annotations

import random

from pyros1.node.watching.liveness import Sighting, State, WatchedNode

A, B = "http://a:1/", "http://b:2/"


def found(pid: int | None = 7) -> WatchedNode:
    watched = WatchedNode("/x", limit=1.0)
    assert watched.state is State.UNSEEN and not watched.on_address(A, 0.0)
    assert [news.alive for news in watched.on_response(pid, 10.0)] == [True]
    return watched


def test_what_never_answered_is_not_lost() -> None:
    watched = WatchedNode("/x", limit=1.0)
    watched.on_address(A, 0.0)
    assert watched.on_failure("refused", 1.0, 1.0, is_port_closed=True) == []
    assert watched.on_failure("silent", 2.0, 5.0) == []
    assert watched.on_address(B, 6.0) == []
    assert watched.state is State.UNSEEN


def test_a_closed_port_is_a_loss_at_once() -> None:
    watched = found()
    (news,) = watched.on_failure("refused", 10.5, 10.5, is_port_closed=True)
    assert news == Sighting("/x", False, "its port is closed: it has exited (refused)", 0.5, A, 7)
    assert str(news) == "/x is lost: its port is closed: it has exited (refused)"
    assert watched.state is State.LOST
    assert watched.on_failure("refused", 11.0, 11.0, is_port_closed=True) == []
    (back,) = watched.on_response(8, 12.0)
    assert (back.alive, back.reason, back.pid) == (True, "it answers", 8)


def test_silence_is_a_loss_after_the_limit() -> None:
    watched = found()
    assert watched.remaining_time(11.0) == 1.0
    assert watched.on_failure("no route", 11.0, 11.1) == []
    assert round(watched.remaining_time(11.2), 6) == 0.8, "the next question may take what is left"
    assert watched.on_failure("no route", 11.2, 11.9) == []
    (news,) = watched.on_failure("silent", 11.9, 12.0)
    assert (news.alive, news.reason, news.silent) == (False, "silent", 2.0)
    (back,) = watched.on_response(7, 13.0)
    assert (back.alive, back.reason) == (True, "it answers again")


def test_an_answer_in_between_begins_the_time_anew() -> None:
    watched = found()
    assert watched.on_failure("reset", 11.0, 11.0) == []
    assert watched.on_response(7, 11.1) == []
    assert watched.on_failure("reset", 12.0, 12.5) == []
    watched.ignore_failure()
    assert watched.on_failure("silent", 13.0, 13.5) == []


def test_another_place_or_process_is_a_replacement() -> None:
    watched = found()
    (lost,) = watched.on_address(B, 11.0)
    assert (lost.alive, lost.uri, lost.reason) == (False, A, f"replaced by a node of the same name at {B}")
    (back,) = watched.on_response(7, 11.2)  # process ids of two machines may be equal
    assert (back.alive, back.uri, back.reason) == (True, B, "it answers")
    lost, back = watched.on_response(9, 12.0)
    assert not lost.alive and lost.pid == 7 and "another process" in lost.reason
    assert back.alive and back.pid == 9
    assert watched.is_new_process(10) and not watched.is_new_process(9)


def test_losses_and_finds_take_turns_whatever_happens() -> None:
    for seed in range(300):
        choose = random.Random(seed)
        watched, now, last = WatchedNode("/x", limit=1.0), 0.0, False
        for _ in range(60):
            now += choose.random()
            kind = choose.choice(("looked up", "answered", "failed", "stalled"))
            news: list[Sighting] = []
            if kind == "looked up":
                news = watched.on_address(choose.choice((A, B)), now)
            elif kind == "answered":
                news = watched.on_response(choose.choice((1, 2, None)), now)
            elif kind == "failed":
                news = watched.on_failure("why", now - choose.random(), now, choose.random() < 0.3)
            else:
                watched.ignore_failure()
            for each in news:
                assert each.alive is not last and each.silent >= 0.0, seed
                last = each.alive
            assert (watched.state is State.FOUND) is last
            assert 0.0 <= watched.remaining_time(now) <= 1.0
