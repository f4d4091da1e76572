"""What a page gets of launches, and the ends of log files."""

from __future__ import annotations

from pathlib import Path

import pytest

from pyros1.launch.running.control import Report, Status
from pyros1.web.models.launches import MAX_PROCESSES, cpu_times, describe, describe_exit, last_lines, log_files


def test_a_launch_is_described() -> None:
    before = Report("a.launch", 1, processes=[Status("a-1", "/a", "running", 7, 1, 10.0, 1.0, 2**20)])
    after = Report(
        "a.launch", 1, 12.0, 1, "no",
        [Status("a-1", "/a", "running", 7, 1, 12.0, 2.0, 2**20, required=True, log="/x/a-1"),
         Status("b-2", "/b", "died", 8, 3, exit_code=-9)],
    )  # fmt: skip
    found = describe(after, 102.0, cpu_times(before, 100.0))
    assert (found["title"], found["uptime"], found["expected"], found["refusal"]) == ("a.launch", 12.0, 1, "no")
    first, second = found["processes"]
    assert (first["cpu"], first["memory"], first["pid"], first["exit"], first["required"]) == (50.0, 2**20, 7, "", True)
    assert (second["cpu"], second["memory"], second["pid"], second["uptime"]) == (None, None, None, None)
    assert (second["state"], second["exit"], second["starts"]) == ("died", "ended by SIGKILL", 3)
    fresh = describe(
        after, 102.0, cpu_times(Report("a", 1, processes=[Status("a-1", "/a", "running", 6, 1, cpu=9.0)]), 100.0)
    )
    assert fresh["processes"][0]["cpu"] is None  # another process of the same name


def test_many_processes_are_cut_with_their_number() -> None:
    many = [Status(f"a-{n}", "/a", "running", n, 1, uptime=float("inf")) for n in range(MAX_PROCESSES + 1)]
    found = describe(Report("a", 1, processes=many), 0.0, {})
    assert (len(found["processes"]), found["count"]) == (MAX_PROCESSES, MAX_PROCESSES + 1)
    assert found["processes"][0]["uptime"] is None  # JSON has no infinity
    found = describe(Report("a", 1, processes=[*many, Status("b-1", "/b", "died", 5, 1)]), 0.0, {})
    assert found["processes"][0]["node"] == "/b"  # it needs a look


@pytest.mark.parametrize(
    ("code", "words"),
    [
        (0, "exit code 0"),
        (3, "exit code 3"),
        (127, "exit code 127: a command was not found"),
        (-11, "ended by SIGSEGV"),
        (-999, "ended by signal 999"),
    ],
)
def test_ends_in_words(code: int, words: str) -> None:
    assert describe_exit(code) == words


def test_only_logs_in_the_folder_of_logs_are_read(tmp_path: Path) -> None:
    logs = tmp_path / "log"
    (logs / "run").mkdir(parents=True)
    for name in ("a-1.log", "a-1-stdout.log", "a-12.log", "a-1.txt"):
        (logs / "run" / name).write_text(name)
    (tmp_path / "secret.log").write_text("secret")
    (logs / "link.log").symlink_to(tmp_path / "secret.log")
    assert [path.name for path in log_files(str(logs / "run" / "a-1"), logs)] == ["a-1.log", "a-1-stdout.log"]
    for base in ("secret", "log/../secret", "log/link", "log/none"):
        assert log_files(str(tmp_path / base), logs) == []


def test_the_end_of_a_long_log(tmp_path: Path) -> None:
    log = tmp_path / "a.log"
    log.write_bytes(b"".join(b"line %d \xff\n" % number for number in range(100_000)))
    lines = last_lines(log).split("\n")
    assert lines[-1] == "line 99999 \N{REPLACEMENT CHARACTER}"
    assert len(lines) == 200
    log.write_text("x" * 100_000)
    assert len(last_lines(log)) == 32_000
    log.write_text("")
    assert last_lines(log) == ""
