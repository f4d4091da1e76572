"""log_file: a full disk costs what is logged meanwhile, and nothing else."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import pytest

from pyros1.ground.log_file import RETRY_INTERVAL, LogFile


@pytest.fixture
def full(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return a function that says how many bytes the disk takes from now on; None: all."""
    real, room = os.write, [None]

    def write(descriptor: int, data: Any) -> int:
        if room[0] is None:
            return real(descriptor, data)
        if not room[0]:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        count = real(descriptor, data[: room[0]])
        room[0] -= count
        return count

    monkeypatch.setattr("pyros1.ground.log_file.os.write", write)

    def set_room(count: int | None) -> None:
        room[0] = count  # type: ignore[call-overload]

    return set_room


def test_it_goes_on_after_a_full_disk_and_says_what_is_missing(
    tmp_path: Path, full: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path, now = tmp_path / "folder" / "n.log", [100.0]
    monkeypatch.setattr("pyros1.ground.log_file.monotonic", lambda: now[0])
    log = LogFile(str(path), 10_000, 2)
    log.write("one\n")
    full(4)
    log.write("two ä and more\n")
    log.write("three\nfour\n")  # not tried
    now[0] += RETRY_INTERVAL
    full(0)
    log.write("five\n")
    now[0] += RETRY_INTERVAL
    full(None)
    log.write("six\n")
    log.write("seven\n")
    log.close()
    lines = path.read_text(encoding="utf-8").splitlines()
    missing = "... 4 lines are missing here: No space left on device"
    assert lines == ["one", "two ", missing, "six", "seven"]
    said = capsys.readouterr().err
    assert said == f"WARNING: cannot write the log file {path}: No space left on device; lines are lost\n"


def test_a_file_that_cannot_be_opened_is_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("pyros1.ground.log_file.RETRY_INTERVAL", 0.0)
    (tmp_path / "folder").write_text("in the way")
    log = LogFile(str(tmp_path / "folder" / "n.log"), 10_000, 2)
    log.write("one\n")
    log.write("two\n")
    (tmp_path / "folder").unlink()
    log.write("three\n")
    log.close()
    text = (tmp_path / "folder" / "n.log").read_text(encoding="utf-8")
    assert text.startswith("... 2 lines are missing here: ") and text.endswith("\nthree\n")
    assert capsys.readouterr().err.count("cannot write") == 1


def test_closing_on_a_full_disk_raises_nothing(tmp_path: Path, full: Any) -> None:
    log = LogFile(str(tmp_path / "n.log"), 10_000, 2)
    full(2)
    log.write("one\n")
    log.close()
    log.write("two\n")
    assert (tmp_path / "n.log").read_text(encoding="utf-8") == "on"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_a_pipe_in_its_place_holds_nobody_up(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    os.mkfifo(tmp_path / "n.log")
    log = LogFile(str(tmp_path / "n.log"), 10_000, 2)
    log.write("one\n")
    log.close()
    assert f"cannot write the log file {tmp_path / 'n.log'}: " in capsys.readouterr().err
