"""Run the same work on pyros1, stock roscpp and stock rospy, taking turns, and print the figures side by side.

::

    python interop/bench/run.py [--quick] [--runs N] [--seconds S] [--only WORDS] [--under CONDITIONS] [--list]
                                [--json FILE] [--html FILE] [--history FILE]

Needs stock ROS and the built roscpp programs (``interop/setup``), and defusedxml. pyros1 runs on the interpreter that
stock rospy runs on: libraries are compared, not interpreters. A cell is the median of the runs with their range, and
"ours vs" says how many times better we are. Absolute figures move with the machine; the ratios of one run do not.
Each row is measured on a quiet machine and beside as many busy programs as it has cores; --under names other
conditions, see `conditions`.
The page of --html plots the ratios with their ranges and goals, and the runs in --history, to which this one is added.

Exit code: 0 all goals are met, 1 one is missed, 2 something failed, 3 stock ROS is not there. --quick says nothing
about goals: 0 or 2.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(1, str(HERE.parent / "peers"))
sys.path.insert(2, str(HERE.parents[1] / "src"))

from conditions import CONDITIONS, QUIET  # noqa: E402
from harness import Master, free_port, missing_stock  # noqa: E402  found through the path above
from model import COLUMNS, Results, ResultsByCondition, Row, Step, distinct_steps  # noqa: E402
from page import history_line, page, read_history  # noqa: E402
from rows import QUICK, all_rows  # noqa: E402
from steps import Bench  # noqa: E402
from table import report, table  # noqa: E402


class Progress:
    """What is being run, and how long the rest will take, on stderr.

    Args:
        steps: the steps of one turn.
        turns: number of turns.
    """

    def __init__(self, steps: list[Step], turns: int) -> None:
        self._left = [*steps] * turns
        self._took: dict[Step, float] = {}

    def begin(self, step: Step, condition: str) -> None:
        average = sum(self._took.values()) / len(self._took) if self._took else 4.0
        left = sum(self._took.get(one, average) for one in self._left)
        say(f"{len(self._left)} to go, about {left / 60:.0f} min: {condition}: {step.label}")
        self._began = time.monotonic()

    def end(self, step: Step) -> None:
        self._left.remove(step)
        self._took[step] = time.monotonic() - self._began


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def measure(bench: Bench, steps: list[Step], runs: int, conditions: list[str], tries: int = 1) -> dict[str, Results]:
    """Run every step once per turn under each condition.

    A step that fails is reported, tried so many times, and does not end the run.
    """
    measured: dict[str, Results] = {condition: {step: [] for step in steps} for condition in conditions}
    progress = Progress(steps, runs * len(conditions))
    for _ in range(runs):
        for condition, results in measured.items():
            for step in steps:
                progress.begin(step, condition)
                results[step].append(attempt(bench, step, condition, tries))
                progress.end(step)
    return measured


def attempt(bench: Bench, step: Step, condition: str, tries: int) -> dict[str, float] | None:
    """Run a step under a condition; None if it failed each time."""
    for _ in range(tries):
        try:
            with CONDITIONS[condition]():
                return step.run(bench)
        except Exception as error:  # noqa: BLE001  whatever it was, the other rows are still wanted
            say(f"FAILED: {step.label}\n{error}")
            bench.master.close_since(0)
            bench.master.stop()  # it may still know nodes that were killed
            bench.master.start()
    return None


def chosen_rows(words: str, quick: bool) -> list[Row]:
    """The rows in whose group and name the words occur. Without words: all, or those of the quick form."""
    rows = [(f"{row.group}: {row.name}", row) for row in all_rows()]
    return [row for name, row in rows if (name in QUICK if quick and not words else words in name)]


def list_rows(rows: list[Row]) -> None:
    """Print what would be measured."""
    for row in rows:
        goals = ", ".join(goal.text(row.unit) for goal in row.goals)
        print(f"{row.group}: {row.name} [{row.unit}] {goals}".rstrip())
        for column in COLUMNS:
            if column in row.steps:
                print(f"    {column}: {row.steps[column].label}")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a short run of a row or two of each group")
    parser.add_argument("--runs", type=int, metavar="N", help="runs of each (5; with --quick 1)")
    parser.add_argument("--seconds", type=float, metavar="S", help="length of a run (2; with --quick 0.5)")
    parser.add_argument("--only", default="", metavar="WORDS", help="only the rows with this in their first column")
    parser.add_argument(
        "--under",
        metavar="CONDITIONS",
        help=f"measure under these conditions: some of {','.join(CONDITIONS)} (quiet,busy; with --quick quiet)",
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every figure to FILE")
    parser.add_argument("--html", type=Path, metavar="FILE", help="write a page with plots to FILE")
    parser.add_argument("--history", type=Path, metavar="FILE", help="add this run to FILE, a line of JSON each")
    parser.add_argument("--list", action="store_true", help="say what would be run, and do not run it")
    options = parser.parse_args()
    rows = chosen_rows(options.only, options.quick)
    if not rows:
        parser.error(f"no row has {options.only!r} in its first column")
    conditions = (options.under or (QUIET if options.quick else f"{QUIET},busy")).split(",")
    unknown = [condition for condition in conditions if condition not in CONDITIONS]
    if unknown:
        parser.error(f"no such condition: {unknown[0]!r}; there are {', '.join(CONDITIONS)}")
    for condition in conditions:
        try:
            with CONDITIONS[condition]():
                pass
        except OSError as error:
            parser.error(f"the condition {condition!r} cannot be made here: {error}")
    try:
        earlier = read_history(options.history) if options.history else []
    except (OSError, ValueError) as error:
        parser.error(str(error))
    if options.list:
        list_rows(rows)
        return 0
    missing = missing_stock()
    if missing:
        say(f"ERROR: {missing}")
        return 3
    runs = options.runs or (1 if options.quick else 5)
    tries = 2 if options.quick else 1  # what fails twice is no accident of a busy machine
    seconds = options.seconds or (0.5 if options.quick else 2.0)
    with tempfile.TemporaryDirectory() as home:
        master = Master("stock", Path(home) / "ros", free_port())
        try:
            master.start()
            bench = Bench(master, Path(home) / "import", seconds)
            measured = measure(bench, distinct_steps(rows), runs, conditions, tries)
        finally:
            master.close()
    print(table(rows, measured))
    figures = report(rows, measured, runs, seconds)
    line = history_line(figures)
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    if options.history:
        with options.history.open("a", encoding="utf-8") as file:
            file.write(line + "\n")
    if options.html:
        options.html.write_text(page(figures, [*earlier, json.loads(line)]), encoding="utf-8")
    return exit_code(rows, measured, options.quick)


def exit_code(rows: list[Row], measured: ResultsByCondition, quick: bool) -> int:
    """What the run amounts to, see above."""
    if any(row.failures(results, column) for results in measured.values() for row in rows for column in row.steps):
        return 2
    missed = any(
        not row.met(results, goal)
        for condition, results in measured.items()
        for row in rows
        for goal in row.goals_under(condition)
    )
    return 1 if missed and not quick else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        say("interrupted: nothing was written")
        sys.exit(130)
