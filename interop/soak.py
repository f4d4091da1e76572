"""Soak: topics, services, parameters and bags for a long time, while nodes come and go; nothing may be lost or grow.

::

    python interop/soak.py [--minutes M] [--json FILE]

Five processes of pyros1 live through it: the core, a talker and a listener (`peers/soak_resident.py`), a recorder
and a player that loops. Visitors come and go: stock rospy (`peers/soak_visitor.py`), roscpp and pyros1, of which one in
four is killed; and nodes in the listener's own process, some of which take the name of another one. All messages have
numbers: what is published on the reliable topics must arrive, once and in order, in the listener, in every visitor for
as long as it is there, and in the bag; on a topic with a slow callback, what did not arrive must be counted as dropped.

Every few seconds the memory, descriptors and threads of the five are read. Memory is resident size; that of the talker
and the listener after `gc.collect` and `malloc_trim`, and also as a number of Python's memory blocks. After a warm-up
none may grow: see `Series.growth`.

Exit code: 0, or 1 if something was lost or grows; 3 without stock ROS.
"""

from __future__ import annotations

import argparse
import itertools
import json
import signal
import statistics
import struct
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent / "peers"))

from harness import PEERS, SOURCE, STOCK_PYTHON, Master, Process, free_port, missing_stock, until

if str(SOURCE) not in sys.path:
    sys.path.insert(0, str(SOURCE))

import pyros1.bag
from pyros1.msgs.std_msgs.msg import Float64

PATIENCE = 60.0
SAMPLE = 4.0
"""Seconds between two samples."""
WARM_UP = 0.3
"""The part of the time whose samples do not count."""
VISIT = 40
"""Messages that a visitor publishes."""
HEARD = 20
PLAYED = 200
PLAY_RATE = 20.0
BAD = ("Traceback", "internal error", "[ERROR]", "[FATAL]", "Exception")
MOST = {"rss": 1536.0, "descriptors": 2.0, "threads": 2.0, "blocks": 1500.0}
"""Most growth: KiB of resident memory, and numbers."""


class Series:
    """Samples of one figure of one process."""

    def __init__(self, process: str, figure: str) -> None:
        self.process = process
        self.figure = figure
        self.samples: list[tuple[float, float]] = []

    def settled(self, end: float) -> list[float]:
        """Return the samples after the warm-up."""
        return [value for when, value in self.samples if when >= WARM_UP * end]

    def growth(self, end: float) -> float:
        """Return by how much the figure has grown after the warm-up.

        That is the median of all slopes between two samples, for the whole time; for numbers that go up and down with
        the visitors, the difference between the least of the first and of the last third.
        """
        counted = [(when, value) for when, value in self.samples if when >= WARM_UP * end]
        if len(counted) < 6:
            return 0.0
        if self.figure == "rss":
            slopes = [(b[1] - a[1]) / (b[0] - a[0]) for a, b in itertools.combinations(counted, 2) if b[0] > a[0]]
            return statistics.median(slopes) * (counted[-1][0] - counted[0][0])
        third = len(counted) // 3
        first, last = counted[:third], counted[-third:]
        return min(value for _, value in last) - min(value for _, value in first)

    def row(self, end: float) -> dict[str, Any]:
        """Return a row of the report."""
        settled = self.settled(end) or [0.0]
        return {
            "process": self.process,
            "figure": self.figure,
            "least": min(settled),
            "most": max(settled),
            "growth": round(self.growth(end), 1),
            "allowed": MOST[self.figure],
        }


class Soak:
    """One run.

    Args:
        folder: for logs and bags.
        seconds: how long.
    """

    def __init__(self, folder: Path, seconds: float) -> None:
        self.faults: list[str] = []
        self.series: dict[tuple[str, str], Series] = {}
        self.visits: dict[str, int] = {"rospy": 0, "roscpp": 0, "pyros1": 0, "killed": 0}
        self.ended = threading.Event()
        self._seconds = seconds
        self._folder = folder
        self._master = Master("ours", folder / "home", free_port())
        self._long: dict[str, Process] = {}

    # Starting and ending ----------------------------------------------------------------------------------------------

    def run(self) -> dict[str, Any]:
        """Run, and return the report."""
        try:
            self._start()
            begun = time.monotonic()
            visiting = threading.Thread(target=self._visit_again_and_again)
            visiting.start()
            while (now := time.monotonic() - begun) < self._seconds:
                self._sample(now)
                self.ended.wait(min(SAMPLE, max(0.0, self._seconds - now)))
            self.ended.set()
            visiting.join(4 * PATIENCE)
            return self._finish()
        finally:
            self.ended.set()
            for process in (*self._master.processes, *self._master.core):
                process.close()

    def _start(self) -> None:
        self._master.start()
        self._long["core"] = self._master.core[0]
        bag = self._folder / "loop.bag"
        with pyros1.bag.open(bag, "w") as out:
            for number in range(PLAYED):
                out.write("/soak/played", Float64(float(number)), 1_700_000_000.0 + number / PLAY_RATE)
        command = [sys.executable, "-m", "pyros1"]
        topics = ["/soak/numbers", "/soak/visits"]
        record = [
            *command,
            "bag",
            "record",
            "--split",
            "--duration",
            "20s",
            "-O",
            str(self._folder / "record"),
            *topics,
        ]
        self._long["recorder"] = self._master.run(record, python="ours", label="recorder")
        for role in ("talker", "listener"):
            resident = [sys.executable, str(PEERS / "soak_resident.py"), role]
            self._long[role] = self._master.run(resident, python="ours", label=role)
            self._long[role].wait_line("^ready$", PATIENCE)
        play = [*command, "bag", "play", "--quiet", "--loop", "--wait-for-subscribers", str(bag)]
        self._long["player"] = self._master.run(play, python="ours", label="player")

    def ask(self, name: str, word: str = "sample") -> dict[str, Any]:
        """Let a resident do something; return what it tells."""
        process = self._long[name]
        process.write(word)
        told: dict[str, Any] = json.loads(process.wait_line("^told (.*)$", 2 * PATIENCE)[1])
        return told

    # Visitors ---------------------------------------------------------------------------------------------------------

    def _visit_again_and_again(self) -> None:
        visits = itertools.cycle((self._visit_of_rospy, self._visit_of_roscpp, self._visit_of_pyros1))
        for number in itertools.count(1):
            if self.ended.wait(1.0):
                return
            try:
                next(visits)(number, number % 4 == 0)
            except AssertionError as error:
                self.faults.append(f"visit {number}: {error}")

    def _visit_of_rospy(self, number: int, kill: bool) -> None:
        command = [STOCK_PYTHON, str(PEERS / "soak_visitor.py"), str(number), str(VISIT)]
        visitor = self._master.run(command, label="visitor of rospy")
        visitor.wait_line("^visited$", 2 * PATIENCE)
        self._end_visit("rospy", visitor, kill)

    def _visit_of_roscpp(self, number: int, kill: bool) -> None:
        self._visit_of_peer("roscpp", kill)

    def _visit_of_pyros1(self, number: int, kill: bool) -> None:
        self._visit_of_peer("pyros1", kill)

    def _visit_of_peer(self, kind: str, kill: bool) -> None:
        visitor = self._master.peer(kind, f"soak_visitor_{kind}")
        visitor.event("ready", timeout=PATIENCE)
        visitor.subscribe("/soak/numbers", "std_msgs/Float64", 1000)
        bodies = [visitor.received("/soak/numbers", PATIENCE) for _ in range(HEARD)]
        heard = [struct.unpack("<d", bytes.fromhex(body))[0] for body in bodies]
        assert heard == [heard[0] + step for step in range(HEARD)], f"{kind} heard {heard}"
        self._end_visit(kind, visitor, kill)

    def _end_visit(self, kind: str, visitor: Process, kill: bool) -> None:
        self.visits[kind] += 1
        if kill:
            self.visits["killed"] += 1
            visitor.signal(signal.SIGKILL)
        else:
            visitor.write("quit")
        visitor.wait(PATIENCE)
        visitor.close()
        self._master.processes.remove(visitor)

    # Sampling ---------------------------------------------------------------------------------------------------------

    def _sample(self, now: float) -> None:
        for name in ("talker", "listener"):
            self._note(name, "blocks", now, self.ask(name)["blocks"])
        for name, process in self._long.items():
            folder = Path(f"/proc/{process.pid}")
            try:
                self._note(name, "rss", now, int((folder / "statm").read_text().split()[1]) * 4)
                self._note(name, "descriptors", now, len(list((folder / "fd").iterdir())))
                self._note(name, "threads", now, len(list((folder / "task").iterdir())))
            except OSError:
                self.faults.append(f"{name} has ended:\n{process.transcript()}")
                self.ended.set()

    def _note(self, name: str, figure: str, now: float, value: float) -> None:
        self.series.setdefault((name, figure), Series(name, figure)).samples.append((now, value))

    # The end ----------------------------------------------------------------------------------------------------------

    def _finish(self) -> dict[str, Any]:
        self.ask("listener", "stop")  # first, or its last nodes would wait for numbers
        sent = self.ask("talker", "stop")["sent"]

        def settled() -> dict[str, Any] | None:
            told = self.ask("listener")
            fast = told["fast"]
            whole = told["numbers"]["last"] == sent["numbers"] - 1
            return told if whole and fast["last"] == sent["fast"] - 1 else None

        listener = self._until(settled, "the listener has the last messages") or self.ask("listener")
        talker = self.ask("talker")
        self._check(talker, listener)
        for name in ("player", "recorder"):
            self._long[name].signal(signal.SIGINT)
            self._long[name].wait(PATIENCE)
        recorded = self._check_bags(sent["numbers"])
        for name in ("talker", "listener"):
            self._long[name].write("quit")
            if self._long[name].wait(PATIENCE):
                self.faults.append(f"{name} ended badly:\n{self._long[name].transcript()}")
        for name, process in self._long.items():  # warnings of what visitors do are right
            bad = [line for line in process.lines if any(word in line for word in BAD)]
            self.faults += [f"{name} said: {line}" for line in bad[:5]]
        end = max((when for series in self.series.values() for when, _ in series.samples), default=0.0)
        rows = [series.row(end) for series in self.series.values()]
        for row in rows:
            if row["growth"] > row["allowed"]:
                self.faults.append(f"{row['process']}: {row['figure']} grew by {row['growth']:g}")
        return {
            "python": sys.version.split()[0],
            "seconds": round(end),
            "talker": talker,
            "listener": listener,
            "visits": self.visits,
            "recorded": recorded,
            "figures": rows,
            "faults": self.faults,
        }

    def _until(self, reached: Callable[[], Any], what: str) -> Any:
        try:
            return until(reached, what, PATIENCE)
        except AssertionError as error:
            self.faults.append(str(error))
            return None

    def _check(self, talker: dict[str, Any], listener: dict[str, Any]) -> None:
        self.faults += talker.pop("faults") + listener.pop("faults")
        for name in ("numbers", "played"):
            row = listener[name]
            if row["gaps"] or not row["count"]:
                self.faults.append(f"{name}: {row}")
        numbers, fast = listener["numbers"], listener["fast"]
        if numbers["count"] != numbers["last"] - numbers["first"] + 1:
            self.faults.append(f"numbers: {numbers}")
        missing = fast["last"] - fast["first"] + 1 - fast["count"]
        dropped = fast["dropped"] + talker["dropped"]["fast"]
        if missing != dropped or not missing:
            self.faults.append(f"of the fast topic {missing:g} messages are missing, {dropped} are counted as dropped")
        if talker["visitors"] < self.visits["rospy"]:
            self.faults.append(f"{talker['visitors']} of {self.visits['rospy']} visitors were heard")
        self.faults += [
            f"of visitor {number} came {row['count']} of {VISIT} messages"
            for number, row in talker["visits"].items()
            if row["count"] != VISIT
        ]

    def _check_bags(self, sent: int) -> dict[str, Any]:
        numbers: list[float] = []
        visits = 0
        for path in sorted(self._folder.glob("record_*.bag"), key=lambda path: int(path.stem.rpartition("_")[2])):
            with pyros1.bag.open(path) as bag:
                for message in bag.messages("/soak/numbers"):
                    numbers.append(message.message.data)
                visits += bag.count("/soak/visits")
        if numbers != [numbers[0] + step for step in range(len(numbers))] if numbers else True:
            self.faults.append(f"the bags have {len(numbers)} numbers, with gaps")
        elif numbers[-1] < sent - 1:
            self.faults.append(f"the bags end with {numbers[-1]:g}, not {sent - 1}")
        if visits != VISIT * self.visits["rospy"]:
            self.faults.append(f"the bags have {visits} messages of {self.visits['rospy']} visitors")
        return {"numbers": len(numbers), "visits": visits}


def shown(report: dict[str, Any]) -> Iterator[str]:
    """Return the lines of a report."""
    talker, listener, visits = report["talker"], report["listener"], report["visits"]
    yield f"Python {report['python']}, {report['seconds']} s"
    yield f"  numbers: {listener['numbers']['count']} received, {talker['sent']['numbers']} sent"
    fast = listener["fast"]
    dropped = f"{fast['dropped']} counted as dropped"
    yield f"  slow callback: {fast['count']} received, {dropped}, {talker['sent']['fast']} sent"
    yield f"  played: {listener['played']['count']}; recorded: {report['recorded']['numbers']}"
    comers = f"nodes in the process: {listener['comers']}"
    yield f"  calls: {talker['calls']}; parameter reads: {listener['reads']}; {comers}"
    yield "  visits: " + ", ".join(f"{kind} {count}" for kind, count in visits.items())
    yield f"  {'process':10} {'figure':12} {'least':>9} {'most':>9} {'growth':>8} {'allowed':>8}"
    for row in report["figures"]:
        figures = " ".join(
            f"{row[key]:{width}g}" for key, width in (("least", 9), ("most", 9), ("growth", 8), ("allowed", 8))
        )
        yield f"  {row['process']:10} {row['figure']:12} {figures}"
    yield from (f"  FAULT: {fault}" for fault in report["faults"])
    yield "  nothing was lost, and nothing grows" if not report["faults"] else f"  {len(report['faults'])} faults"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run it as a program; return the exit code."""
    parser = argparse.ArgumentParser(description="Run topics, services, parameters and bags for a long time.")
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--json", type=Path, help="write the report to this file, too")
    options = parser.parse_args(arguments)
    missing = missing_stock()
    if missing:
        print(missing, file=sys.stderr)
        return 3
    with tempfile.TemporaryDirectory(prefix="pyros1-soak-") as folder:
        report = Soak(Path(folder), 60.0 * options.minutes).run()
    print("\n".join(shown(report)))
    if options.json is not None:
        options.json.write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
    return 1 if report["faults"] else 0


if __name__ == "__main__":
    sys.exit(main())
