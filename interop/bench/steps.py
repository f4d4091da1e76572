"""How figures are measured: which programs are started for each step, and which of them says the figures."""

from __future__ import annotations

import importlib.util
import json
import math
import os
import re
import statistics
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

from faces import START as START_FOLDER
from harness import DEADLINE, SOURCE, STOCK_PYTHON, Master, Process
from model import FACE, OURS, ROSCPP, ROSPY

HERE = Path(__file__).resolve().parent
PROGRAMS = {
    OURS: [STOCK_PYTHON, str(HERE / "node_bench.py")],
    ROSCPP: [str(HERE.parent / "build" / "roscpp_bench")],
    ROSPY: [STOCK_PYTHON, str(HERE / "rospy_bench.py")],
    FACE: [STOCK_PYTHON, str(HERE / "rospy_bench.py")],
    "drain": [STOCK_PYTHON, str(HERE / "drain.py")],
}
LONG = 60.0  # seconds; a program that another one outlives
LOCAL = "transports=local"
"""The option for our local transport; the others' programs pay no attention to it."""
START = 30.0  # seconds that a program may need to come up


class Bench:
    """The running master, and how to start programs beside it.

    Args:
        master: a stock master.
        folder: for what the stock interpreter lacks.
        seconds: length of a measurement.
    """

    def __init__(self, master: Master, folder: Path, seconds: float) -> None:
        self.master = master
        self.seconds = seconds
        self._path = import_path(folder)

    def start(self, program: Program, seconds: float) -> Process:
        """Start one of the benchmark programs."""
        words = program.options.split()
        command = [*PROGRAMS[program.kind], program.role, *words, f"seconds={seconds}"]
        variables = self._variables(program.kind)
        variables["PYROS1_TRANSPORTS"] = "local,tcp" if LOCAL in words else "tcp"
        return self.master.run(command, label=program.label, **variables)

    def output(self, *command: str, kind: str, timeout: float = 120) -> str:
        """Run a command to its end and return what it prints on standard output."""
        environ = self.master.environ(**self._variables(kind))
        done = subprocess.run(command, env=environ, capture_output=True, text=True, timeout=timeout, check=False)
        assert done.returncode == 0, f"{' '.join(command)}: exit code {done.returncode}\n{done.stderr[-2000:]}"
        return done.stdout

    def _variables(self, kind: str) -> dict[str, str | None]:
        """What the environment says to a program of a kind."""
        if kind == FACE:  # without the word a real rospy would win
            return {
                "PYTHONPATH": f"{START_FOLDER}{os.pathsep}{self._path}",
                "PYROS1_ROSPY": "pyros1",
            }
        return {"PYTHONPATH": self._path if kind == OURS else None}


def import_path(folder: Path) -> str:
    """What the stock interpreter needs on PYTHONPATH for pyros1: its source, and defusedxml from this environment."""
    spec = importlib.util.find_spec("defusedxml")
    if spec is None or spec.origin is None:
        raise SystemExit("ERROR: defusedxml is not installed here; pip install pyros1 or defusedxml")
    folder.mkdir()
    (folder / "defusedxml").symlink_to(Path(spec.origin).parent)
    return f"{SOURCE}{os.pathsep}{folder}"


def figures_of(process: Process, timeout: float) -> dict[str, float]:
    """The figures that a program prints at its end."""
    line = process.wait_line("^figures (.*)", timeout)[1]
    return {name: float(value) for name, value in re.findall(r"(\w+)=(\S+)", line)}


@dataclass(frozen=True)
class Program:
    """One of the benchmark programs in a role (see roles.py).

    Attributes:
        kind: ``ours``, ``face``, ``roscpp``, ``rospy``, or ``drain``.
        role: what it does.
        options: its KEY=VALUE arguments, but the seconds.
    """

    kind: str
    role: str
    options: str = ""

    @property
    def label(self) -> str:
        return f"{self.kind} {self.role}"


@dataclass(frozen=True)
class Together:
    """Programs that are started one after the other, each when the one before is ready.

    Attributes:
        programs: the programs.
        talking: index of the one that says the figures; those before it run until they are stopped, so those after do.
    """

    programs: tuple[Program, ...]
    talking: int = -1

    @property
    def label(self) -> str:
        return ", ".join(f"{one.label} {one.options}" for one in self.programs)

    def run(self, bench: Bench) -> dict[str, float]:
        mark = len(bench.master.processes)
        running: list[Process] = []
        talking = self.programs[self.talking]
        try:
            for program in self.programs:
                if running:
                    running[-1].wait_line("^ready", START)
                running.append(bench.start(program, bench.seconds if program is talking else LONG))
            return figures_of(running[self.talking], START + bench.seconds)
        finally:
            bench.master.close_since(mark)


@dataclass(frozen=True)
class Crowd:
    """A publisher with some subscribers, each in a process of its own.

    Attributes:
        kind: whose programs.
        options: their arguments.
        count: number of subscribers.
    """

    kind: str
    options: str
    count: int

    @property
    def label(self) -> str:
        return f"{self.kind} to {self.count} processes {self.options}"

    def run(self, bench: Bench) -> dict[str, float]:
        """Return what all subscribers get together."""
        mark = len(bench.master.processes)
        try:
            heard = [bench.start(Program(self.kind, "sub", self.options), bench.seconds) for _ in range(self.count)]
            for process in heard:
                process.wait_line("^ready", START)
            bench.start(Program(self.kind, "pub", f"{self.options} wait={self.count}"), LONG)
            each = [figures_of(process, START + bench.seconds) for process in heard]
            return {name: sum(figures[name] for figures in each) for name in each[0]}
        finally:
            bench.master.close_since(mark)


@dataclass(frozen=True)
class ControlLoop:
    """A sensor, a controller and an actuator, each a process.

    Attributes:
        kind: whose programs.
        options: their arguments.
    """

    kind: str
    options: str

    @property
    def label(self) -> str:
        return f"{self.kind} sense, control, act {self.options}"

    def run(self, bench: Bench) -> dict[str, float]:
        """Return the times from the sensor to the actuator, and what the three take of the processor together."""
        mark = len(bench.master.processes)
        running: list[Process] = []
        try:
            for role in ("act", "control", "sense"):
                if running:
                    running[-1].wait_line("^ready", START)
                running.append(bench.start(Program(self.kind, role, self.options), bench.seconds))
            found = [figures_of(process, START + bench.seconds) for process in running]
            return {**found[0], "cpu": sum(figures["cpu"] for figures in found)}
        finally:
            bench.master.close_since(mark)


@dataclass(frozen=True)
class FanOut:
    """A publisher with many subscribers and one more: once that one reads as they do, and once it never reads.

    So both times there is as much to send, and what is kept of the rate is what the stuck one costs beyond that.

    Attributes:
        kind: whose publisher.
        options: its arguments.
        links: number of subscribers that read.
    """

    kind: str
    options: str
    links: int

    @property
    def label(self) -> str:
        return f"{self.kind} to {self.links} {self.options}"

    def run(self, bench: Bench) -> dict[str, float]:
        free, _ = self._once(bench, self.links + 1, stuck=0)
        held, grown = self._once(bench, self.links, stuck=1)
        return {"free": free, "held": held, "kept": 100 * held / free if free else math.nan, "rss": grown}

    def _once(self, bench: Bench, links: int, stuck: int) -> tuple[float, float]:
        """Messages per second and subscriber, and the MB by which the publisher's process grew."""
        mark = len(bench.master.processes)
        try:
            options = f"{self.options} wait={links + stuck}"
            publisher = bench.start(Program(self.kind, "pub", options), bench.seconds + 2)
            publisher.wait_line("^ready", START)
            drain = bench.start(Program("drain", "drain", f"links={links} stuck={stuck}"), bench.seconds)
            rate = figures_of(drain, START + bench.seconds)["rate"]
            # A publisher that waits for the stuck subscriber (rospy's) comes to its end only when that one has gone.
            drain.close()
            return rate, figures_of(publisher, START)["rss"]
        finally:
            bench.master.close_since(mark)


@dataclass(frozen=True)
class Script:
    """A script that prints a JSON object of figures.

    Attributes:
        name: file name, here.
        side: ``ours`` or ``stock`` (or a kind of program): what it measures.
        options: its other arguments.
        python: the interpreter that runs it.
    """

    name: str
    side: str
    options: str = ""
    python: str = STOCK_PYTHON

    @property
    def label(self) -> str:
        return f"{self.name} {self.side} {self.options}".rstrip()

    def run(self, bench: Bench) -> dict[str, float]:
        command = (self.python, str(HERE / self.name), "--side", self.side, *self.options.split())
        out = bench.output(*command, kind=OURS)
        return {name: float(value) for name, value in json.loads(out.splitlines()[-1]).items()}


@dataclass(frozen=True)
class Import:
    """How long a program needs for its imports, after the interpreter's start.

    Attributes:
        statement: the import.
        kind: ``ours``, ``face`` or ``rospy``.
    """

    statement: str
    kind: str

    @property
    def label(self) -> str:
        return self.statement

    def run(self, bench: Bench) -> dict[str, float]:
        code = f"import time; t = time.perf_counter(); {self.statement}; print((time.perf_counter() - t) * 1e3)"
        times = [float(bench.output(STOCK_PYTHON, "-c", code, kind=self.kind)) for _ in range(4)]
        return {"ms": statistics.median(times[1:])}  # the first one warms the caches


@dataclass(frozen=True)
class Command:
    """How long a command runs, from its start to its end.

    Attributes:
        command: program and arguments.
        ours: pyros1 is needed.
    """

    command: tuple[str, ...]
    ours: bool

    @property
    def label(self) -> str:
        return " ".join(self.command)

    def run(self, bench: Bench) -> dict[str, float]:
        times = []
        for _ in range(4):
            start = time.perf_counter()
            bench.output(*self.command, kind=OURS if self.ours else ROSPY, timeout=DEADLINE)
            times.append((time.perf_counter() - start) * 1e3)
        return {"ms": statistics.median(times[1:])}  # the first one warms the caches
