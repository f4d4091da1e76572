"""Keys of a terminal, and the terminal as it was afterwards."""

from __future__ import annotations

import os
import pty
import select
import signal
import subprocess
import sys
import termios
import time
from pathlib import Path

import pytest

import pyros1
from pyros1.finding.packages import OWN_PACKAGES
from pyros1.ground.keys import KeyReader, NoTerminalError, key_names

PATIENCE = 20.0
TELEOP = Path(OWN_PACKAGES) / "turtlesim" / "scripts" / "turtle_teleop_key"
ECHO = 3
"""Where a terminal's settings have the flag for echoing."""


def test_what_a_terminal_sends() -> None:
    assert key_names("q\x1b[A\x1bOB\x1b[Cx\x1b[D") == ["q", "up", "down", "right", "x", "left"]
    assert key_names("\x1b[") == key_names("\x1b[Z") == [] and key_names("") == []


def test_without_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    with open(os.devnull) as nothing:
        monkeypatch.setattr("sys.stdin", nothing)
        with pytest.raises(NoTerminalError, match="standard input is not a terminal"), KeyReader():
            pass


def test_a_terminal_without_job_control(monkeypatch: pytest.MonkeyPatch) -> None:
    """As nodes of a launch have it."""
    ours, theirs = pty.openpty()
    try:
        with open(theirs, closefd=False) as terminal:
            monkeypatch.setattr("sys.stdin", terminal)
            before = termios.tcgetattr(theirs)
            with KeyReader() as keys:
                assert not termios.tcgetattr(theirs)[ECHO] & termios.ECHO
                assert keys.read(0.0) == []
                os.write(ours, b"\x1b[Ag")
                assert keys.read(PATIENCE) == ["up", "g"]
            assert termios.tcgetattr(theirs) == before
    finally:
        os.close(ours)
        os.close(theirs)


@pytest.mark.parametrize("end", ["q", signal.SIGINT, signal.SIGTERM], ids=str)
def test_the_program_restores_the_terminal(end: str | int, environ: dict[str, str]) -> None:
    """Feature: turtle_teleop_key restores the terminal however it exits"""
    ours, theirs = pty.openpty()
    before = termios.tcgetattr(theirs)
    env = {**os.environ, **environ, "PYTHONPATH": str(Path(pyros1.__file__).parents[1])}
    child = subprocess.Popen(
        [sys.executable, TELEOP], stdin=theirs, stdout=theirs, stderr=theirs, env=env, start_new_session=True
    )
    try:
        said, until = "", time.monotonic() + PATIENCE
        while "'q' to quit." not in said and time.monotonic() < until and child.poll() is None:
            if select.select([ours], [], [], 0.1)[0]:
                said += os.read(ours, 4096).decode()
        assert "Use arrow keys to move the turtle." in said
        assert not termios.tcgetattr(theirs)[ECHO] & termios.ECHO
        if isinstance(end, str):
            os.write(ours, end.encode())
        else:
            child.send_signal(end)
        assert child.wait(PATIENCE) == 0
        assert termios.tcgetattr(theirs) == before
    finally:
        child.kill()
        child.wait()
        os.close(ours)
        os.close(theirs)


def test_a_key_that_comes_in_two_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    ours, theirs = pty.openpty()
    monkeypatch.setattr(sys, "stdin", os.fdopen(theirs, "r"))
    with KeyReader() as keys:
        found = []
        for part in (b"q\x1b", b"[", b"C\x1b[", b"Dx"):
            os.write(ours, part)
            found += keys.read(PATIENCE) or []
    assert found == ["q", "right", "left", "x"]
    sys.stdin.close()
    os.close(ours)
