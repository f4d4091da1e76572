"""pyros1 run (L22-L24)."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from pyros1.cli.running import run_command

SOURCES = Path(__file__).resolve().parents[3] / "src"


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "some_pkg"
    (folder / "scripts").mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>some_pkg</name></package>")
    script = folder / "scripts" / "hello"
    script.write_text('#!/bin/sh\necho "hello $*"\nexit 7\n')
    script.chmod(0o755)
    (folder / "scripts" / "data").write_text("no program")
    (tmp_path / "empty_pkg").mkdir()
    (tmp_path / "empty_pkg" / "package.xml").write_text("<package><name>empty_pkg</name></package>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    return folder


def run(*words: str) -> subprocess.CompletedProcess[str]:
    code = "import sys; from pyros1.cli.running import run_command; sys.exit(run_command('run', sys.argv[1:]))"
    env = {**os.environ, "PYTHONPATH": str(SOURCES)}
    return subprocess.run(
        [sys.executable, "-c", code, *words], env=env, capture_output=True, text=True, timeout=30, check=False
    )


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
        (["some_pkg"], 0, "hello\n"),
        (["empty_pkg"], 3, "[rosrun] the package empty_pkg in "),
        (["sme_pkg"], 2, "[rosrun] (did you mean 'some_pkg'?)"),
        (["--help"], 0, "Usage: pyros1 run"),
        (["some_pkg", "hello/"], 1, "[rosrun] Couldn't find executable named hello/"),
        (["no_such_pkg", "hello"], 2, "[rospack] Error: package 'no_such_pkg' not found"),
        (["some_pkg", "nope"], 3, "[rosrun] Couldn't find executable named nope below "),
        (["some_pkg", "data"], 3, "or not executable"),
        (["sme_pkg", "hello"], 2, "[rosrun] (did you mean 'some_pkg'?)"),
        (["some_pkg", "helo"], 3, "[rosrun] (did you mean 'hello'?)"),
    ],
)
def test_errors_l24(package: Path, capsys: pytest.CaptureFixture[str], words: list[str], code: int, text: str) -> None:
    assert run_command("run", words) == code
    captured = capsys.readouterr()
    assert text in captured.out + captured.err


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["--prefx", "gdb", "some_pkg", "hello"], "no such option: --prefx (did you mean '--prefix'?)"),
        (["--prefx=gdb", "some_pkg", "hello"], "no such option: --prefx=gdb (did you mean '--prefix'?)"),
        (["--nope", "some_pkg"], "no such option: --nope"),
        (["-x"], "no such option: -x"),
        (["--prefix"], "--prefix needs a value"),
    ],
)
def test_unknown_options(package: Path, capsys: pytest.CaptureFixture[str], words: list[str], text: str) -> None:
    with pytest.raises(SystemExit, match="2"):
        run_command("run", words)
    assert capsys.readouterr().err.endswith(f"pyros1 run: error: {text}\n")


def test_unknown_options_under_the_name_of_stock(
    package: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.argv", ["/usr/bin/rosrun"])
    assert run_command("run", ["-x"]) == 0
    assert capsys.readouterr().out.startswith("Usage: rosrun")


def test_words_that_only_look_like_remappings_are_passed_on_with_a_hint(package: Path) -> None:
    words = ["_rate=10", "foo=1", "rate:10", "\u2013r", "left:=right", "robot:11311", "plain", "--x=1"]
    done = run("some_pkg", "hello", *words)
    assert done.stdout == f"hello {' '.join(words)}\n"
    hints = done.stderr.splitlines()
    assert [line.partition("; the argument")[0].rpartition(" ")[2] for line in hints] == [
        "_rate:=10",
        "foo:=1",
        "rate:=10",
        "-r",
    ]
    assert hints[0].startswith("[rosrun] '_rate=10' is neither a remapping nor a parameter: write _rate:=10")


def test_a_script_that_names_no_interpreter(package: Path, capsys: pytest.CaptureFixture[str]) -> None:
    script = package / "scripts" / "hello"
    script.write_bytes(b"#!/usr/bin/env python3\r\nprint(1)\r\n")
    assert run_command("run", ["some_pkg", "hello"]) == 126
    text = (
        f"[rosrun] cannot run {script}: it has Windows line endings (CR LF), which make its first line invalid: sed -i"
    )
    assert capsys.readouterr().err.startswith(text)
    script.write_text("echo hello\n")
    assert run_command("run", ["some_pkg", "hello"]) == 126
    assert "does not name an interpreter" in capsys.readouterr().err
    assert run("--prefix", "sh", "some_pkg", "hello").stdout == "hello\n", "the prefix runs it"


@pytest.mark.slow
def test_run_and_launch_find_the_same(package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    devel, site = tmp_path / "devel", tmp_path / "site-packages"
    for file, text in {
        devel / "lib/some_pkg/hello": "echo libexec",
        devel / "share/spaced/package.xml": "<package><name>spaced</name></package>",
        devel / "lib/spaced/tool": "echo spaced",
        site / "declared/package.xml": "<package><name>declared</name></package>",
        site / "declared/nodes/tool": "echo declared",
    }.items():
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text if file.suffix else f"#!/bin/sh\n{text}\n")
        file.chmod(0o755)
    monkeypatch.setenv("CMAKE_PREFIX_PATH", str(devel))
    monkeypatch.setenv("PYTHONPATH", f"{site}:{SOURCES}")

    def pyros1(*words: str, given: str = "") -> str:
        command = [sys.executable, "-m", "pyros1", *words]
        return subprocess.run(command, input=given, capture_output=True, text=True, timeout=30, check=True).stdout

    for name, kind, said in (
        ("some_pkg", "hello", "libexec"),
        ("spaced", "tool", "spaced"),
        ("declared", "tool", "declared"),
    ):
        assert pyros1("run", name, kind) == f"{said}\n"
        path = pyros1("run", "--prefix", "echo", name, kind).strip()
        arguments = pyros1(
            "launch", "--args", "/n", "-", given=f'<launch><node pkg="{name}" type="{kind}" name="n"/></launch>'
        )
        assert path in arguments.split()
