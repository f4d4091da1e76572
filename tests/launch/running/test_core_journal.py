"""launch.running.core_journal: what a core says about the journal of another, and takes from it."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pyros1.launch.running.core_journal import CoreJournal, set_aside_journal


class Said:
    """A console that keeps what it is told."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def line(self, text: str) -> None:
        self.lines.append(text)

    def warning(self, text: str) -> None:
        self.lines.append(f"WARNING {text}")


@pytest.fixture
def made() -> Iterator[list[CoreJournal]]:
    """What a test makes; what is left ends with it."""
    found: list[CoreJournal] = []
    yield found
    for each in found:
        each.release()


def make(made: list[CoreJournal], home: Path) -> tuple[CoreJournal, Said]:
    said: Any = Said()
    made.append(CoreJournal({"ROS_HOME": str(home)}, 11311, said))
    return made[-1], said


def leave(made: list[CoreJournal], home: Path, *calls: Any) -> Path:
    """Leave the journal of a killed core; return its file."""
    earlier, _ = make(made, home)
    assert earlier.journal is not None and earlier.previous is None
    earlier.journal.rewrite(calls)
    earlier.release()
    (path,) = (home / "pyros1").glob("*.journal")
    return path


def test_a_killed_core_is_continued_under_its_run_id(made: list[CoreJournal], tmp_path: Path) -> None:
    leave(made, tmp_path, ("setParam", ["/", "/", {"run_id": "one", "x": 1}]), ("setParam", ["/a", "/run_id", "two"]))
    core, said = make(made, tmp_path)
    assert core.previous_run_id == "two" and core.previous is not None
    assert said.lines == [f"restoring the state of the master that was killed (pid {os.getpid()})"]
    core.report(1, ["/rosout"])
    core.report(2, [f"/n{number}" for number in range(30)])
    assert said.lines[1] == "resumed with 1 node from the previous master"
    assert said.lines[2].startswith("resumed with 2 nodes from the previous master; no longer running: /n0, /n1")
    assert said.lines[2].endswith("/n19 ...")


def test_calls_that_are_none_of_a_parameter_are_no_run_id(made: list[CoreJournal], tmp_path: Path) -> None:
    leave(
        made,
        tmp_path,
        ("setParam", ["/a", "/run_id"]),
        ("setParam", ["/a", "/run_id", 5]),
        ("setParam", ["/a", "/x", "y"]),
    )
    assert make(made, tmp_path)[0].previous_run_id is None


def test_a_core_that_does_not_start_leaves_the_journal_for_the_next_one(
    made: list[CoreJournal], tmp_path: Path
) -> None:
    path = leave(made, tmp_path, ("setParam", ["/a", "/run_id", "one"]))
    core, _ = make(made, tmp_path)
    core.release()
    assert core.journal is None and path.exists()
    core.release()
    assert make(made, tmp_path)[0].previous_run_id == "one"


def test_an_old_one_is_set_aside(made: list[CoreJournal], tmp_path: Path) -> None:
    path = leave(made, tmp_path, ("setParam", ["/a", "/x", 1]))
    os.utime(path, (time.time() - 3600,) * 2)
    core, said = make(made, tmp_path)
    assert core.previous is None and core.previous_run_id is None and core.journal is not None
    assert "none of its nodes is running" in said.lines[0] and str(path.with_suffix(".old")) in said.lines[0]
    assert path.with_suffix(".old").exists() and not path.exists()


def test_a_master_without_a_journal_sets_it_aside(made: list[CoreJournal], tmp_path: Path) -> None:
    path = leave(made, tmp_path, ("setParam", ["/a", "/x", 1]))
    said: Any = Said()
    set_aside_journal({"ROS_HOME": str(tmp_path)}, 11311, said)
    set_aside_journal({"ROS_HOME": str(tmp_path)}, 11311, said)  # there is none any more
    assert len(said.lines) == 1 and "its state is not restored, as this master has no journal" in said.lines[0]
    assert path.with_suffix(".old").stat().st_size > 0
    assert path.with_suffix(".old").exists() and not path.exists()
    used, _ = make(made, tmp_path)
    assert used.previous is None and used.journal is not None
    used.journal.rewrite(())
    until = time.monotonic() + 20
    while not path.exists():
        assert time.monotonic() < until
    set_aside_journal({"ROS_HOME": str(tmp_path)}, 11311, said)  # of a core that runs
    assert path.exists()


def test_a_spoilt_one_is_set_aside(made: list[CoreJournal], tmp_path: Path) -> None:
    leave(made, tmp_path).write_text("hello")
    core, said = make(made, tmp_path)
    assert core.previous is None and "is not the journal of a master" in said.lines[0]


def test_a_cut_one_is_used_as_far_as_it_goes(made: list[CoreJournal], tmp_path: Path) -> None:
    path = leave(made, tmp_path, ("setParam", ["/a", "/run_id", "one"]), ("setParam", ["/a", "/run_id", "two"]))
    path.write_bytes(path.read_bytes()[:-3])
    core, said = make(made, tmp_path)
    assert core.previous_run_id == "one" and "except for its last changes" in said.lines[0]


def test_without_a_journal_a_core_runs_too(made: list[CoreJournal], tmp_path: Path) -> None:
    make(made, tmp_path)
    second, said = make(made, tmp_path)
    assert second.journal is None and "another master is using" in said.lines[0]
    (tmp_path / "file").write_text("")
    third, said = make(made, tmp_path / "file")
    assert third.journal is None and "has no journal" in said.lines[0]
