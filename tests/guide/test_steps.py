"""The guide is run as it stands there: each file, each command, and what it printed, but for numbers and times.

``&`` lets a command run on in the background, ``kill %N`` ends the N-th of those; `pyros1.guide.text` says the rest.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from pyros1.graph import Graph
from pyros1.ground.errors import MasterUnreachableError
from pyros1.guide.text import steps
from pyros1.net.master_client import MasterClient

DEADLINE = 40.0

pytestmark = pytest.mark.skipif(sys.platform == "win32" or shutil.which("bash") is None, reason="a guide for shells")


class Typed(NamedTuple):
    """One command of the guide."""

    command: str
    output: list[str]

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ends it."""
        return "^C" in self.output

    @property
    def background(self) -> bool:
        """Whether it runs on."""
        return self.command.endswith(" &")


def commands(text: str) -> list[Typed]:
    """The commands in the blocks of a text."""
    found: list[Typed] = []
    for block in re.findall(r"^```console\n(.*?)^```", text, re.M | re.S):
        for line in block.splitlines():
            if line.startswith("$ "):
                found.append(Typed(line[2:], []))
            else:
                found[-1].output.append(line)
    return found


NUMBER = r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?"
_HOST = re.compile(r"http://[\w.-]+:\d+/")


def pattern(lines: list[str]) -> re.Pattern[str]:
    """What output must match: numbers and addresses may be others, spaces before numbers too."""
    parts = []
    for line in lines:
        if line == "...":
            parts.append(r"(?:.*\n)*?")
            continue
        if line == "^C":
            break
        text = _HOST.sub("URI", line.rstrip())
        escaped = re.escape(text).replace(r"\ ", " ")
        flexible = re.sub(r"(?<![A-Za-z_/])(?:\\-)?\d+(?:\\\.\d+)?(?:e[+-]?\d+)?", lambda _: NUMBER, escaped)
        flexible = flexible.replace(" " + NUMBER, " +" + NUMBER).replace("URI", r"http://[\w.-]+:\d+/")
        parts.append(flexible + r"[ \t]*\n")
    return re.compile("".join(parts))


class Running:
    """A command of the guide and what it has printed so far."""

    def __init__(self, command: str, folder: Path, environ: dict[str, str]) -> None:
        self.command = command
        self.process = subprocess.Popen(
            ["bash", "-c", command if "|" in command or ">" in command else f"exec {command}"],
            cwd=folder, env=environ, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True, start_new_session=True,
        )  # fmt: skip
        self.output = ""
        self._more = threading.Condition()
        self._ended = False
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            with self._more:
                self.output += line
                self._more.notify_all()
        with self._more:
            self._ended = True
            self._more.notify_all()

    def expect(self, lines: list[str], *, whole: bool) -> None:
        """Wait until the output is as it should be: all of it, or its beginning."""
        wanted = pattern(lines)
        match = wanted.fullmatch if whole else wanted.match
        with self._more:
            self._more.wait_for(lambda: (self._ended if whole else match(self.output)) or self._ended, DEADLINE)
            assert match(self.output), f"$ {self.command}\n{self.output}\n--- wanted:\n" + "\n".join(lines)

    def end(self, number: int = signal.SIGINT) -> None:
        """Press Ctrl-C, as a terminal does: the whole group gets it."""
        if self.process.poll() is None:
            os.killpg(self.process.pid, number)
        self.process.wait(DEADLINE)
        self._reader.join(DEADLINE)
        if self.process.stdout is not None:
            self.process.stdout.close()


@pytest.fixture
def environ(tmp_path: Path, free_port: int) -> dict[str, str]:
    """A home of its own, a master of its own, and nothing of a stock ROS."""
    programs = tmp_path / "bin"
    programs.mkdir()
    source = Path(__file__).resolve().parents[2] / "src"
    for name, module in (("pyros1", "pyros1"), ("python", None), ("python3", None)):
        start = f'exec "{sys.executable}" -m {module} "$@"' if module else f'exec "{sys.executable}" "$@"'
        (programs / name).write_text(f"#!/bin/sh\n{start}\n")
        (programs / name).chmod(0o755)
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("ROS", "CMAKE", "PYROS1"))}
    return {
        **kept,
        "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": str(source),
        "PYTHONUNBUFFERED": "1",
        "HOME": str(tmp_path),
        "ROS_HOME": str(tmp_path / ".ros"),
        "ROS_MASTER_URI": f"http://localhost:{free_port}",
        "ROS_HOSTNAME": "localhost",
    }


@pytest.fixture
def jobs() -> Iterator[list[Running]]:
    """What runs in the background; all ended after the test."""
    started: list[Running] = []
    yield started
    for job in reversed(started):
        job.end()


def busy_nodes(environ: dict[str, str]) -> set[str]:
    """The nodes that have topics or services of their own."""
    client = MasterClient("/reader", environ["ROS_MASTER_URI"])
    try:
        state = Graph(client).state()
    except MasterUnreachableError:
        return set()
    finally:
        client.close()
    tables = (state.publishers, state.subscribers, state.services)
    all_have = ("rosout", "/get_loggers", "/set_logger_level")
    named = (item for table in tables for item in table.items())
    return {node for name, nodes in named if not any(each in name for each in all_have) for node in nodes}


def wait_for(done: Callable[[], object], what: str) -> None:
    """A person looks before typing the next command; so wait until a program is there."""
    until = time.monotonic() + DEADLINE
    while not done():
        assert time.monotonic() < until, f"nothing came of: {what}"
        time.sleep(0.02)


def test_all_steps(tmp_path: Path, environ: dict[str, str], jobs: list[Running]) -> None:
    folder = tmp_path / "work"
    folder.mkdir()
    ran = 0
    for guide_step in steps():
        for name, content in guide_step.files.items():
            (folder / name).write_text(content)
        ran += run_commands(guide_step.text, folder, environ, jobs)
    assert ran >= 40


def run_commands(text: str, folder: Path, environ: dict[str, str], jobs: list[Running]) -> int:
    """Type the commands of a text; return how many there were."""
    ran = 0
    for step in commands(text):
        ran += 1
        if step.command.startswith("cd "):
            folder = (folder / step.command[3:].strip()).resolve()
        elif step.command.startswith("kill %"):
            for number in re.findall(r"%(\d+)", step.command):
                jobs[int(number) - 1].end(signal.SIGTERM)
        elif step.background:
            before = busy_nodes(environ)
            job = Running(step.command[:-2], folder, environ)
            jobs.append(job)
            job.expect(step.output, whole=False)
            if " core" not in step.command:
                wait_for(lambda before=before: busy_nodes(environ) - before, step.command)
        else:
            command = Running(step.command, folder, environ)
            try:
                command.expect(step.output, whole=not step.interrupted)
            finally:
                command.end()
    return ran


def test_numbers_of_the_guide_may_differ_and_nothing_else() -> None:
    assert pattern(["average rate: 10.001", "\tmin: 0.100s max: 0.1s"]).match(
        "average rate: 9.9\n\tmin: 1s max: -2.5s\n"
    )
    assert not pattern(["data: 1.0"]).match("date: 1.0\n")
    assert not pattern(["/topic1"]).match("/topic2\n")
    assert pattern(["a", "...", "b"]).match("a\nx\ny\nb\n")
    assert pattern([" * /t (http://here:1234/)"]).match(" * /t (http://localhost:99/)\n")
