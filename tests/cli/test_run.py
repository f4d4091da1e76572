# ruff: noqa: E501 - tables in one line
"""pyros1 run (L22-L24)."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from pyros1.cli.run import main

SOURCES = Path(__file__).resolve().parents[2] / "src"


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "some_pkg"
    (folder / "scripts").mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>some_pkg</name></package>")
    script = folder / "scripts" / "hello"
    script.write_text('#!/bin/sh\necho "hello $*"\nexit 7\n')
    script.chmod(0o755)
    (folder / "scripts" / "data").write_text("no program")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    return folder


def run(*words: str) -> subprocess.CompletedProcess[str]:
    code = "import sys; from pyros1.cli.run import main; sys.exit(main(sys.argv[1:]))"
    env = {**os.environ, "PYTHONPATH": str(SOURCES)}
    return subprocess.run([sys.executable, "-c", code, *words], env=env, capture_output=True, text=True, timeout=30, check=False)


def test_the_program_replaces_the_command_l22(package: Path) -> None:
    done = run("some_pkg", "hello", "a", "b:=c")
    assert (done.returncode, done.stdout) == (7, "hello a b:=c\n")
    done = run("--prefix", "env X=1", "some_pkg", "scripts/hello")
    assert (done.returncode, done.stdout) == (7, "hello \n")


def test_own_nodes_run_without_executable_bit_in_this_interpreter(package: Path) -> None:
    done = run("--debug", "-p", "echo", "minimal_nodes", "minimal_publisher", "_rate:=1")
    script = SOURCES / "pyros1/packages/minimal_nodes/scripts/minimal_publisher"
    assert done.stdout.splitlines()[-1] == f"{sys.executable} {script} _rate:=1"


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        ([], 0, "Usage: pyros1 run"),
        (["some_pkg"], 0, "Usage: pyros1 run"),
        (["--help"], 0, "Usage: pyros1 run"),
        (["some_pkg", "hello/"], 1, "[rosrun] Couldn't find executable named hello/"),
        (["no_such_pkg", "hello"], 2, "[rospack] Error: package 'no_such_pkg' not found"),
        (["some_pkg", "nope"], 3, "[rosrun] Couldn't find executable named nope below "),
        (["some_pkg", "data"], 3, "or not executable"),
    ],
)
def test_errors_l24(package: Path, capsys: pytest.CaptureFixture[str], words: list[str], code: int, text: str) -> None:
    assert main(words) == code
    captured = capsys.readouterr()
    assert text in captured.out + captured.err
