"""unit: one test program without a master (L181); beside stock rosunit in interop/test_tools_more.py."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pyros1.cli import unit
from pyros1.cli.unit import UnableError, UnitRun

Run = Callable[..., tuple[int, str, str]]
PACKAGE = "<package><name>tested</name></package>"
RESULTS = (
    '<testsuite tests="{0}" failures="{1}" errors="0" name="s" time="0"><testcase classname="C" name="one" time="0.1"/>'
)
FAILED = '<testcase classname="C" name="two" time="0"><failure type="E" message="1 is not 2"/></testcase>'
PROGRAM = """#!/bin/sh
for word; do case $word in --gtest_output=xml:*) file=${{word#--gtest_output=xml:}};; esac; done
{0}
"""


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "package.xml").write_text(PACKAGE)
    monkeypatch.setenv("ROS_TEST_RESULTS_DIR", str(tmp_path / "results"))
    return tmp_path


def program(place: Path, text: str, name: str = "check.sh") -> str:
    path = place / name
    path.write_text(PROGRAM.format(text))
    path.chmod(0o755)
    return str(path)


@pytest.fixture
def run(place: Path, capfd: Any) -> Run:
    def call(*words: str) -> tuple[int, str, str]:
        try:
            code = unit.main(list(words))
        except SystemExit as end:
            code = int(end.code or 0)
        return (code, *capfd.readouterr())

    return call


def writing(text: str) -> str:
    return f"cat > \"$file\" <<'END'\n{text}</testsuite>\nEND\n"


def test_a_good_program_l181(run: Run, place: Path) -> None:
    code, out, err = run(program(place, "echo heard $1; " + writing(RESULTS.format(1, 0))), "word")
    wrapper = place / "results" / "tested" / "rostest-check.xml"
    assert (code, err) == (0, "")
    assert out.startswith(f"[ROSUNIT] Outputting test results to {wrapper}\nheard word\n[Testcase: runTest] ... ok\n")
    assert "[tested.rosunit-check/one][passed]\n\nSUMMARY\n\x1b[32m * RESULT: SUCCESS" in out
    assert " * TESTS: 1\n * ERRORS: 0\n * FAILURES: 0\n" in out
    assert 'name="runTest"' in wrapper.read_text() and "results are in" in wrapper.read_text()


def test_failures_are_told_l181(run: Run, place: Path) -> None:
    words = ["--name", "other name", "--package", "pack", program(place, writing(RESULTS.format(2, 1) + FAILED))]
    code, out, _ = run(*words)
    assert code == 2 and "1 is not 2" in out and " * FAILURES: 1" in out
    names = sorted(path.name for path in (place / "results" / "pack").iterdir())
    assert names == ["rostest-other_name.xml", "rosunit-other_name.xml"]


def test_what_cannot_be_run_l181(run: Run, place: Path) -> None:
    code, out, _ = run(program(place, "exit 0"))
    assert code == 1 and "FAILURE: test [check] did not generate test results" in out
    code, out, _ = run(str(place / "nothing"))
    assert code == 1 and "unable to launch" in out and "No such file" in out
    code, out, _ = run("--time-limit", "0.2", program(place, "exec sleep 100"))
    assert code == 1 and "ERROR: test max time allotted: 0.2 s" in out
    (place / "package.xml").unlink()
    assert run(str(place / "check.sh"))[:2] == (
        1,
        f"Error: {place}/check.sh is in no package; give its name with --package\n",
    )
    assert run()[0] == 2 and run("--time-limit", "x", "y")[0] == 2


def test_on_the_screen_l181(run: Run, place: Path) -> None:
    code, out, _ = run("-t", program(place, 'echo "$1"; exit 3'))
    assert code == 2 and out.startswith("--text\n[Testcase: runTest] ... ok\n") and "not accurate" in out
    assert run("-t", program(place, "exit 0"))[0] == 0


def test_python_runs_what_is_called_py(run: Run, place: Path) -> None:
    (place / "case.py").write_text("import sys; print('python', len(sys.argv)); sys.exit(0)\n")
    assert run("-t", str(place / "case.py"))[1].startswith("python 3\n")


def test_it_ends_by_a_signal_with_all_it_started(place: Path) -> None:
    """A pipe that the program and what it started hold open ends when the last of them has."""
    os.mkfifo(place / "up")
    script = f"trap 'exit 7' INT\nexec 3> {place}/up\nsleep 1000 &\necho up >&3\nwait"
    unit_run = UnitRun(Path(program(place, script)), [], "check", place / "none.xml")
    seen: list[str] = []

    def interrupt() -> None:
        with (place / "up").open() as pipe:
            seen.append(pipe.readline())
            os.kill(os.getpid(), signal.SIGUSR1)
            seen.append(pipe.read())

    before = signal.signal(signal.SIGUSR1, lambda number, frame: unit_run.stop("SIGUSR1"))
    thread = threading.Thread(target=interrupt)
    thread.start()
    try:
        with pytest.raises(UnableError, match="interrupted by SIGUSR1"):
            unit_run.run()
        thread.join()
    finally:
        signal.signal(signal.SIGUSR1, before)
    assert seen == ["up\n", ""]
