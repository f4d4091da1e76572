"""clean: what is removed, and above all what is not (L179)."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pyros1.cli.running import run_command
from pyros1.doctor.disk import files_in_use, folder_size, format_size_like_du

Run = Callable[..., tuple[int, str, str]]
QUESTION = "PLEASE BE CAREFUL TO VERIFY THE COMMAND BELOW!\nOkay to perform:\n\n"


@pytest.fixture
def logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "logs"
    folder.mkdir()
    monkeypatch.setenv("ROS_LOG_DIR", str(folder))
    monkeypatch.setenv("ROS_HOME", str(tmp_path / "home"))
    return folder


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: Any) -> Run:
    def call(*words: str, stdin: str = "") -> tuple[int, str, str]:
        monkeypatch.setattr("sys.stdin", io.StringIO(stdin))
        try:
            code = run_command("clean", list(words))
        except SystemExit as end:
            code = int(end.code or 0)
        return (code, *capsys.readouterr())

    return call


def test_check_l179(run: Run, logs: Path) -> None:
    (logs / "a").write_bytes(b"x" * 10_000)
    size = folder_size(logs, on_disk=True)
    assert size >= 10_000
    assert run("check") == (0, f"{format_size_like_du(size)} ROS node logs\n", "")
    assert json.loads(run("check", "--json")[1]) == [{"what": "ROS node logs", "folder": str(logs), "bytes": size}]


@pytest.mark.skipif(not os.path.exists("/proc/self/fd"), reason="the system does not tell which files are open")
def test_purge_keeps_what_is_being_written_and_the_link_to_it(run: Run, logs: Path) -> None:
    for name in ("run1", "run2"):
        (logs / name).mkdir()
        (logs / name / "node.log").write_text("x")
    (logs / "latest").symlink_to(logs / "run2")
    with (logs / "run2" / "node.log").open("a"):
        assert files_in_use(logs) == [logs / "run2" / "node.log"]
        code, out, err = run("purge", stdin="y\n")
        assert code == 0 and out.endswith(f"rm -rf {logs} (except latest, run2)\n(y/n)?\n")
        assert "kept, because running programs write to these logs: latest, run2" in err
        assert sorted(os.listdir(logs)) == ["latest", "run2"]
        assert run("purge", "-y", "--running") == (0, "Purging ROS node logs.\n", "")
    assert not logs.exists()


@pytest.mark.parametrize("answer", ["n\n", "maybe\nN\n", ""])
def test_without_a_yes_nothing_is_removed(run: Run, logs: Path, answer: str) -> None:
    (logs / "a").write_text("x")
    assert run("purge", stdin=answer) == (0, f"Purging ROS node logs.\n{QUESTION}rm -rf {logs}\n(y/n)?\n", "")
    assert run("purge", "--size", "-1", stdin=answer)[0] == 0
    assert (logs / "a").exists()


def test_links_are_removed_and_not_followed(run: Run, logs: Path, tmp_path: Path) -> None:
    outside = tmp_path / "precious"
    outside.mkdir()
    (outside / "data").write_bytes(b"x" * 100_000)
    (logs / "run").mkdir()
    (logs / "link").symlink_to(outside)
    (logs / "run" / "link").symlink_to(outside)
    assert folder_size(logs) < 50_000
    assert run("purge", "-y")[0] == 0
    assert not logs.exists() and (outside / "data").exists()


def test_a_linked_log_folder_is_cleaned_and_its_place_kept_safe(
    run: Run, logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    link = tmp_path / "link"
    link.symlink_to(logs)
    monkeypatch.setenv("ROS_LOG_DIR", str(link))
    assert f"rm -rf {logs}\n" in run("purge", stdin="y\n")[1]
    assert not logs.exists() and link.is_symlink()


def test_the_oldest_go_first(run: Run, logs: Path) -> None:
    for age, name in enumerate(("new", "middle", "old")):
        (logs / name).write_bytes(b"x" * 3_000_000)
        os.utime(logs / name, (1e9 - age, 1e9 - age))
    assert "is 8 MB which is already below the requested threshold of 9 MB." in run("purge", "--size", "9")[1]
    code, out, _ = run("purge", "--size", "6", stdin="y\n")
    assert code == 0 and out.startswith("Purging ROS node logs until directory size is at most 6 MB (currently 8 MB).")
    assert sorted(os.listdir(logs)) == ["middle", "new"]
    run("purge", "-y", "--size", "3")
    assert os.listdir(logs) == ["new"]


def test_home_and_what_is_above_is_never_removed(run: Run, logs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (logs / "inner").mkdir()
    monkeypatch.setenv("HOME", str(logs / "inner"))
    code, _, err = run("purge", "-y")
    assert code == 1 and "correct ROS_LOG_DIR" in err and logs.exists()


def test_what_cannot_be_removed_is_said(run: Run, logs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: Any) -> None:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr("shutil.rmtree", refuse)
    code, _, err = run("purge", "-y")
    assert code == 1 and "FAILED" in err and "Permission denied" in err


@pytest.mark.parametrize(
    ("size", "text"),
    [(0, "0"), (512, "512"), (4096, "4.0K"), (4097, "4.1K"), (10_239, "10K"), (278_528, "272K"), (1_048_064, "1.0M")],
)
def test_sizes_are_those_of_du(size: int, text: str) -> None:
    assert format_size_like_du(size) == text
