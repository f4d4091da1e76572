"""One at a time sends to a client."""

from __future__ import annotations

from pyros1.web.server.turns import Turns


def free() -> Turns:
    turns = Turns()
    turns.release()
    return turns


def test_at_first_the_loop_has_to_look() -> None:
    turns = Turns()
    assert not turns.is_free and turns.begin() is False
    turns.release()
    assert turns.is_free and not turns.is_threads


def test_one_thread_sends() -> None:
    turns = free()
    assert turns.begin() and turns.is_threads
    assert not turns.is_free and not turns.begin()
    turns.release()  # of the loop, which has nothing to release
    assert turns.is_threads and not turns.begin()
    assert not turns.end()
    assert turns.is_free and not turns.is_threads


def test_what_is_queued_is_the_loops() -> None:
    turns = free()
    assert turns.leave_to_loop()
    assert turns.leave_to_loop()  # it may have seen the first
    assert not turns.is_free and not turns.begin()
    turns.release()
    assert turns.begin()


def test_what_is_queued_while_a_thread_sends_wakes_the_loop_afterwards() -> None:
    turns = free()
    assert turns.begin()
    assert turns.leave_to_loop() is False and turns.is_threads
    assert turns.end()
    assert not turns.is_free and not turns.is_threads and not turns.begin()
    turns.release()
    assert turns.begin() and not turns.end()
