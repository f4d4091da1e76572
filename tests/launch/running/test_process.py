"""launch.running.process: signals to processes whose system or whose user is another one."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NoReturn

import pytest

from pyros1.launch.running import process as module
from pyros1.launch.running import watchdog
from pyros1.launch.running.process import Process
from pyros1.launch.running.process_spec import ProcessSpec

DEADLINE = 20.0


@pytest.fixture
def sleeper(tmp_path: Path) -> Iterator[Process]:
    """A process that dies of the first signal."""
    process = Process(ProcessSpec("a-1", "/a", ["/bin/sleep", "100"], {}, str(tmp_path)), lambda ended: None)
    process.start()
    yield process
    process.kill()
    process.join()


def code(process: Process) -> int | None:
    assert process.wait(time.monotonic() + DEADLINE)
    return process.exit_code


def refuse(error: type[OSError]) -> Callable[[int, int], NoReturn]:
    def kill(pid: int, number: int) -> NoReturn:
        raise error(1, "no")

    return kill


def test_without_process_groups_only_other_signals_than_ctrl_c_end_a_process(
    sleeper: Process, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on Windows, where it has got the terminal's Ctrl-C itself."""
    monkeypatch.setattr(module, "HAS_PROCESS_GROUPS", False)
    with monkeypatch.context() as context:
        context.setattr(subprocess.Popen, "send_signal", lambda *arguments: pytest.fail("it got a signal"))
        sleeper.signal(signal.SIGINT)
    sleeper.signal(signal.SIGTERM)
    assert code(sleeper) == -signal.SIGTERM


def test_a_signal_that_the_group_must_not_get_goes_to_the_process(
    sleeper: Process, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A child of it has become another user, as with sudo."""
    monkeypatch.setattr(os, "killpg", refuse(PermissionError))
    sleeper.signal(signal.SIGINT)
    monkeypatch.undo()
    assert code(sleeper) == -signal.SIGINT


def test_a_signal_to_what_has_just_ended_is_no_error(sleeper: Process, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "killpg", refuse(ProcessLookupError))
    sleeper.signal(signal.SIGINT)
    monkeypatch.undo()
    sleeper.signal(signal.SIGTERM)
    assert code(sleeper) == -signal.SIGTERM


@pytest.mark.parametrize("has_groups", [False, True])
def test_a_group_of_which_nothing_may_be_known_is_not_taken_for_a_rest(
    monkeypatch: pytest.MonkeyPatch, has_groups: bool
) -> None:
    """Its id may belong to a process of another user."""
    monkeypatch.setattr(watchdog, "HAS_PROCESS_GROUPS", has_groups)
    monkeypatch.setattr(os, "kill", refuse(PermissionError))
    assert not watchdog.is_leaderless(os.getpid())
    monkeypatch.undo()
