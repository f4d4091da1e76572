"""Real-time priorities: what the system is asked for, and what people are told."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from pyros1.ground.errors import NodeError
from pyros1.ground.realtime import check_priority, set_priority

pytestmark = pytest.mark.skipif(not hasattr(os, "SCHED_FIFO"), reason="only Linux has real-time priorities")
CODE = "import threading; threading.Thread(target=input, daemon=True).start(); print('ready', flush=True); input()"


@pytest.fixture
def child() -> Iterator[subprocess.Popen[str]]:
    """A program with two threads."""
    with subprocess.Popen(
        [sys.executable, "-c", CODE], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None and process.stdout.readline() == "ready\n"
        yield process
        process.kill()


@pytest.mark.parametrize(("given", "number"), [(0, 0), (1, 1), (99, 99), ("50", 50), (True, 1)])
def test_what_is_a_priority(given: Any, number: int) -> None:
    assert check_priority(given, "it") == number


@pytest.mark.parametrize("given", [-1, 100, "100", "", "high", "5.0", 5.0, None, [5]])
def test_what_is_none(given: Any) -> None:
    with pytest.raises(ValueError, match=r"it must be a whole number from 0 \(none\) to 99, not "):
        check_priority(given, "it")


def test_all_threads_of_a_process(child: subprocess.Popen[str]) -> None:
    threads = [int(name) for name in os.listdir(f"/proc/{child.pid}/task")]
    assert len(threads) == 2
    try:
        set_priority(7, child.pid)
    except NodeError as error:  # where nobody may, not even root in a container
        assert "cannot get real-time priority 7: the system does not permit it" in str(error)
        return
    assert {os.sched_getparam(thread).sched_priority for thread in threads} == {7}
    assert {os.sched_getscheduler(thread) for thread in threads} == {os.SCHED_FIFO}
    set_priority(0, child.pid)
    assert {os.sched_getscheduler(thread) for thread in threads} == {os.SCHED_OTHER}


def test_a_thread_that_another_one_creates_meanwhile(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its creator had no priority yet, so that it has none."""
    asked: list[int] = []
    release = threading.Event()
    created = threading.Thread(target=release.wait)

    def record(thread: int, policy: int, param: os.sched_param) -> None:
        assert policy == os.SCHED_FIFO and param.sched_priority == 3
        if not asked:
            created.start()
        asked.append(thread)

    monkeypatch.setattr(os, "sched_setscheduler", record)
    try:
        set_priority(3, os.getpid())
    finally:
        release.set()
        created.join()
    assert created.native_id in asked and len(asked) == len(set(asked))


def refuse(error: OSError) -> Callable[..., None]:
    def set_scheduler(*_: object) -> None:
        raise error

    return set_scheduler


def test_what_is_not_permitted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_setscheduler", refuse(PermissionError(1, "Operation not permitted")))
    with pytest.raises(
        NodeError, match=r"priority 50: .*Add `USER - rtprio 99` to /etc/security/limits.conf .*sys_nice"
    ):
        set_priority(50, os.getpid())
    monkeypatch.setattr(os, "sched_setscheduler", refuse(OSError(22, "Invalid argument")))
    with pytest.raises(NodeError, match=r"cannot get real-time priority 50: Invalid argument$"):
        set_priority(50, os.getpid())
    monkeypatch.delattr(os, "SCHED_FIFO")
    with pytest.raises(NodeError, match="only Linux has these priorities"):
        set_priority(50, os.getpid())


def test_a_process_that_has_ended(child: subprocess.Popen[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_setscheduler", refuse(ProcessLookupError(3, "No such process")))
    set_priority(5, os.getpid())
    child.kill()
    child.wait()
    set_priority(5, child.pid)
