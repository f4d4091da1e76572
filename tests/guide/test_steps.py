"""The guide is run as it stands there: each file, each command, and what it printed, but for numbers and times.

``&`` lets a command run on in the background, here with its output in a pipe; the others print to a terminal, where
some say more, or go on until Ctrl-C. `pyros1.guide.documents` says the rest. As a program this types all steps one
after the other, as a reader does: ``python tests/guide/test_steps.py [PORT PORT]``.

Feature: the guide -- each file, command and output is tested; exercises are checked
"""

from __future__ import annotations

import contextlib
import itertools
import os
import re
import shlex
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import pytest
from forks import Forks

from pyros1.graph import Graph
from pyros1.ground.errors import MasterUnreachableError
from pyros1.guide.documents import GuideStep, steps
from pyros1.net.master_client import MasterClient

DEADLINE = 40.0
SIZE = (40, 120)
"""Rows and columns of the terminal."""

pytestmark = [
    pytest.mark.once,
    pytest.mark.skipif(sys.platform == "win32" or shutil.which("bash") is None, reason="a guide for shells"),
]


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
_HOST = re.compile(r"http://[\w.-]+:\d+/?")
_TOKEN = re.compile(r"token=[\w-]+(?:#\w+=eyJ[\w.-]*)?")
_ESCAPE = re.compile(r"\x1b\[[\d;?]*[A-Za-z]|\x1b\][^\x07]*\x07")
SECOND_TERMINAL = "# in a second terminal"
"""Says that a program runs on there, and reads keys."""
_STRAY = "names no topic or service: this is an HTTP request"
"""An HTTP request at a TCPROS port: programs of other tests may call a port that was theirs before."""


def pattern(lines: list[str]) -> re.Pattern[str]:
    """What output must match: numbers and addresses may be others, spaces before numbers and between columns too."""
    parts = []
    for line in lines:
        if line == "...":
            parts.append(r"(?:.*\n)*?")
            continue
        if line == "^C":
            break
        text = _TOKEN.sub("TOKEN", _HOST.sub("URI", line.rstrip())).replace("/home/me", "HOME")
        escaped = re.escape(text).replace(r"\ ", " ")
        flexible = re.sub(r"(?<![A-Za-z_/])(?:\\-)?\d+(?:\\\.\d+)?(?:e[+-]?\d+)?", lambda _: NUMBER, escaped)
        flexible = re.sub(r"(?<=[^ ])  +", "  +", flexible)  # columns are as wide as they must be
        flexible = (
            flexible.replace(" " + NUMBER, " +" + NUMBER).replace("URI", _HOST.pattern).replace("TOKEN", _TOKEN.pattern)
        ).replace("HOME", r"\S+")
        parts.append(flexible + r"[ \t]*\n")
    return re.compile("".join(parts))


def open_terminal() -> tuple[int, int]:
    """Return two file descriptors: what is written to the second is for a terminal, whose screen the first reads."""
    import fcntl
    import termios

    reading, writing = os.openpty()
    fcntl.ioctl(writing, termios.TIOCSWINSZ, struct.pack("HHHH", *SIZE, 0, 0))
    return reading, writing


class Running:
    """A command of the guide and what it has printed so far.

    Args:
        command: the line that is typed.
        folder: where.
        environ: environment variables.
        forks: starts commands of pyros1; None: a shell starts all of them.
        terminal: whether it prints to a terminal.
        keys: whether it also reads keys from it; see `press`.
    """

    def __init__(
        self,
        command: str,
        folder: Path,
        environ: dict[str, str],
        forks: Forks | None,
        *,
        terminal: bool = False,
        keys: bool = False,
    ) -> None:
        self.command = command
        self._shell: subprocess.Popen[bytes] | None = None
        reading, writing = open_terminal() if terminal else os.pipe()
        self._keys = reading if keys else None
        words = shlex.split(command)
        if forks and words[0] == "pyros1" and not keys and "$(" not in command:
            self._pid = forks.start(words, folder, environ, writing)
        else:
            line = command if "|" in command or ">" in command else f"exec env {command}"
            self._shell = subprocess.Popen(
                ["bash", "-c", line],
                cwd=folder, env=environ, stdin=writing if keys else subprocess.DEVNULL, stdout=writing, stderr=writing,
                start_new_session=True,
            )  # fmt: skip
            self._pid = self._shell.pid
        os.close(writing)
        self.output = ""
        self._more = threading.Condition()
        self._ended = False
        self._reader = threading.Thread(target=self._read, args=(reading,))
        self._reader.start()

    def _read(self, reading: int) -> None:
        # A terminal whose programs have ended is an error to Linux.
        with contextlib.suppress(OSError), open(reading, encoding="utf-8") as lines:
            for line in lines:
                if _STRAY in line:
                    continue
                with self._more:
                    self.output += _ESCAPE.sub("", line)
                    self._more.notify_all()
        with self._more:
            self._ended = True
            self._more.notify_all()

    def press(self, key: str) -> None:
        """Press a key."""
        assert self._keys is not None
        os.write(self._keys, key.encode())

    def expect(self, lines: list[str], *, whole: bool) -> None:
        """Wait until the output is as it should be: all of it, or its beginning."""
        wanted = pattern(lines)
        match = wanted.fullmatch if whole else wanted.match
        with self._more:
            self._more.wait_for(lambda: (self._ended if whole else match(self.output)) or self._ended, DEADLINE)
            assert match(self.output), f"$ {self.command}\n{self.output}\n--- wanted:\n" + "\n".join(lines)

    def end(self) -> None:
        """Press Ctrl-C, as a terminal does: the whole group gets it."""
        if not self._ended:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._pid, signal.SIGINT)
        self._reader.join(DEADLINE)
        assert not self._reader.is_alive(), f"Ctrl-C does not end {self.command}"
        if self._shell:
            self._shell.wait(DEADLINE)


def environment(home: Path, master_port: int) -> dict[str, str]:
    """A home of its own, a master of its own, and no settings of a stock ROS; its packages may be on this machine."""
    programs = home / "bin"
    programs.mkdir(parents=True)
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
        "HOME": str(home),
        "ROS_HOME": str(home / ".ros"),
        "ROS_MASTER_URI": f"http://localhost:{master_port}",
        "ROS_IP": "127.0.0.1",
        "BROWSER": "true",  # the program, which opens nothing
        "PYTEST_ADDOPTS": "-p no:hypothesispytest",  # which readers need not have, and which takes a second to load
    }


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
        time.sleep(0.1)


class Reader:
    """Someone who types steps, in a folder and with a master of their own. Ends all that runs at the end.

    Args:
        home: a new folder.
        ports: of the master, and of the second one that a step starts.
        forks: starts commands of pyros1; None: a shell starts all of them.
    """

    def __init__(self, home: Path, ports: tuple[int, int], forks: Forks | None = None) -> None:
        self.environ = environment(home, ports[0])
        self.second = str(ports[1])
        self.folder = home / "work"
        self.folder.mkdir()
        self.jobs: list[Running] = []
        self.typed = 0
        self._forks = forks

    def __enter__(self) -> Reader:
        return self

    def __exit__(self, *_: object) -> None:
        for job in reversed(self.jobs):
            job.end()

    def write(self, step: GuideStep) -> None:
        """Make the files of a step."""
        for name, content in step.files.items():
            path = self.folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(content)

    def read(self, step: GuideStep) -> None:
        """Do what a step says."""
        self.write(step)
        for typed in commands(step.text):
            self.type(typed)

    def type(self, typed: Typed) -> None:
        """Type one command, at the reader's own ports."""
        self.typed += 1
        line = typed.command.replace("11312", self.second).replace("pyros1 web", "pyros1 web --port 0")
        if line.endswith(SECOND_TERMINAL):
            self.jobs.append(Running(line, self.folder, self.environ, self._forks, terminal=True, keys=True))
            self.jobs[-1].expect(typed.output, whole=False)
            self.jobs[-1].press("u")  # which the step says
            return
        if not typed.background:
            command = Running(line, self.folder, self.environ, self._forks, terminal=True)
            try:
                command.expect(typed.output, whole=not typed.interrupted)
            finally:
                command.end()
            return
        before = busy_nodes(self.environ)
        self.jobs.append(Running(line.removesuffix(" &"), self.folder, self.environ, self._forks))
        self.jobs[-1].expect(typed.output, whole=False)
        if not re.search(r"pyros1 (core|web)", line):
            wait_for(lambda: busy_nodes(self.environ) - before, line)


CHAPTERS = ((1, 2), (3, 4, 5, 6), (7, 8, 9, 10, 11), (12, 13, 14), (15,))
"""Steps that build on each other. Chapters are typed side by side, since most of the time goes into waiting."""


def read_chapter(numbers: tuple[int, ...], home: Path, ports: tuple[int, int], forks: Forks) -> int:
    """Type some steps, with the master, the package and the files of the steps before them. Return how many commands.

    A shell starts the commands of the first chapter; the others are forks, which takes a third of the time.
    """
    known = steps()
    with Reader(home, ports, forks if numbers[0] > 1 else None) as reader:
        if numbers[0] > 1:
            for typed in commands(known[0].text)[:2]:
                reader.type(typed)
            for step in known[: numbers[0] - 1]:
                reader.write(step)
            for script in (reader.folder / "my_robot" / "scripts").iterdir():
                script.chmod(0o755)
        for number in numbers:
            reader.read(known[number - 1])
        return reader.typed


@pytest.mark.slow
def test_all_steps(tmp_path: Path, free_ports: Callable[[int], list[int]]) -> None:
    assert [number for chapter in CHAPTERS for number in chapter] == [step.number for step in steps()]
    ports = free_ports(2 * len(CHAPTERS))
    pairs = zip(ports[::2], ports[1::2], strict=True)
    homes = [tmp_path / f"chapter{chapter[0]}" for chapter in CHAPTERS]
    with contextlib.closing(Forks()) as forks, ThreadPoolExecutor(len(CHAPTERS)) as readers:
        assert sum(readers.map(read_chapter, CHAPTERS, homes, pairs, itertools.repeat(forks))) > 75


@pytest.mark.slow
@pytest.mark.parametrize("shell", ["bash", "zsh"])
def test_one_command_ends_all_jobs_of_a_terminal(shell: str, tmp_path: Path, free_port: int) -> None:
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not here")
    commands = dict(zip(("bash", "zsh"), re.findall(r"`(kill \$[^`]+)`", steps()[0].text), strict=True))
    script = tmp_path / "typed"
    started = "pyros1 core &\npyros1 run minimal_nodes minimal_publisher &\n"
    script.write_text(f"{started}read line\n{commands[shell]}\nwait\necho all ended\n")
    environ = environment(tmp_path / "home", free_port)
    terminal = subprocess.Popen(
        [shell, str(script)], cwd=tmp_path, env=environ, text=True, start_new_session=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    try:
        wait_for(lambda: "/minimal_publisher" in busy_nodes(environ), "pyros1 run")
        output, _ = terminal.communicate("\n", timeout=DEADLINE)
        assert output.endswith("all ended\n") and "illegal" not in output
        assert busy_nodes(environ) == set()
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(terminal.pid, signal.SIGKILL)
        terminal.wait(DEADLINE)


def test_a_command_of_the_guide_that_prints_something_else_is_found(tmp_path: Path, free_port: int) -> None:
    with Reader(tmp_path / "home", (free_port, 0)) as reader, pytest.raises(AssertionError, match=r"wanted:\n +b"):
        reader.type(Typed("echo a", ["b"]))


def test_numbers_of_the_guide_may_differ_and_nothing_else() -> None:
    assert pattern(["average rate: 10.001", "\tmin: 0.100s max: 0.1s"]).match(
        "average rate: 9.9\n\tmin: 1s max: -2.5s\n"
    )
    assert not pattern(["data: 1.0"]).match("date: 1.0\n")
    assert not pattern(["/topic1"]).match("/topic2\n")
    assert pattern(["a", "...", "b"]).match("a\nx\ny\nb\n")
    assert pattern([" * /t (http://here:1234/)"]).match(" * /t (http://localhost:99/)\n")


if __name__ == "__main__":
    # The ports of the master and of the second one may be given: others may have masters here.
    given = int(sys.argv[1] if sys.argv[1:] else 11411), int(sys.argv[2] if sys.argv[2:] else 11412)
    with tempfile.TemporaryDirectory() as place, Reader(Path(place) / "home", given) as only:
        for each in steps():
            only.read(each)
            print(each.number, each.title, flush=True)
