"""Many questions at once."""

from __future__ import annotations

import threading

import pytest

from pyros1.doctor import concurrent as module
from pyros1.doctor.concurrent import run_concurrently
from pyros1.ground.errors import DeadlineError


def test_answers_errors_and_order() -> None:
    def fail() -> int:
        raise ValueError("no")

    answers = run_concurrently({"a": lambda: 1, "b": fail, "c": lambda: 3}, 10.0)
    assert list(answers) == ["a", "b", "c"] and answers["a"] == 1 and answers["c"] == 3
    assert isinstance(answers["b"], ValueError)
    assert run_concurrently({}, 10.0) == {}


def test_they_run_at_the_same_time() -> None:
    all_there = threading.Barrier(20)
    answers = run_concurrently(dict.fromkeys(range(20), lambda: all_there.wait(10)), 20.0)
    assert sorted(answers.values(), key=str) == sorted(range(20), key=str)


def test_who_is_late_is_left_behind() -> None:
    go_on = threading.Event()
    answers = run_concurrently({"slow": go_on.wait, "quick": lambda: True}, 0.1)
    go_on.set()
    assert isinstance(answers["slow"], DeadlineError) and answers["quick"] is True


def test_those_who_had_to_wait_are_asked_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_THREADS", 2)
    assert set(run_concurrently(dict.fromkeys(range(10), lambda: True), 10.0).values()) == {True}
