"""Run the same work on pyros1, stock roscpp and stock rospy, taking turns, and print the figures side by side.

::

    python interop/bench/run.py [--quick] [--json FILE] [--runs N] [--seconds S] [--only WORDS]

Needs stock ROS and the built roscpp programs (``interop/setup``), and defusedxml. pyros1 runs on the interpreter that
stock rospy runs on: libraries are compared, not interpreters. A cell is the median of the runs with their range.
Absolute figures move with the machine; the ratios of one run do not. Exit code 1 if a goal is missed.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import platform
import statistics
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "peers"))

from harness import SOURCE, STOCK_PYTHON, Master, Process, free_port, missing_stock  # noqa: E402  found through the path above

OURS, ROSCPP, ROSPY = "ours", "roscpp", "rospy"
PROGRAMS = {
    OURS: [STOCK_PYTHON, str(HERE / "node_bench.py")],
    ROSCPP: [str(HERE.parent / "build" / "roscpp_bench")],
    ROSPY: [STOCK_PYTHON, str(HERE / "rospy_bench.py")],
}
RATE, BANDWIDTH = r"received (\d+) /s", r"([\d.]+) MB/s"
P50, P99, CALLS = r"p50 (\d+)", r"p99 (\d+)", r"calls (\d+) /s"


@dataclass
class Work:
    """One line of the table.

    Attributes:
        name: what is measured.
        unit: of the figures.
        waiting: role of the program that starts first; given as (role, arguments before the seconds).
        acting: role of the program that starts second.
        figures_from_acting: the second program prints the figure, not the first.
        pattern: where the figure is in the output.
        pairs: for each column, who plays the waiting role and who the acting one.
        queues: queue argument for each implementation.
        against: the column that the ratio compares with.
        goal: what the ratio has to be, and the same as text; None if there is no goal.
    """

    name: str
    unit: str
    waiting: str
    acting: str
    figures_from_acting: bool
    pattern: str
    pairs: dict[str, tuple[str, str]]
    queues: dict[str, str]
    against: str
    goal: tuple[Callable[[float], bool], str] | None = None
    size: int = 0
    values: dict[str, list[float]] = field(default_factory=dict)


ALONE = {kind: (kind, kind) for kind in (OURS, ROSCPP, ROSPY)}
SAME = {OURS: "1000", ROSCPP: "1000", ROSPY: "1000"}
IMAGES = {OURS: "10", ROSCPP: "10", ROSPY: "10"}
BEST = {OURS: "1000", ROSCPP: "1000", ROSPY: "None"}
ABOVE = (lambda ratio: ratio > 1, "> roscpp")


def works() -> list[Work]:
    """The table's lines."""
    to_ours = {OURS: (OURS, ROSCPP), ROSCPP: (ROSCPP, ROSCPP), ROSPY: (ROSPY, ROSCPP)}
    to_roscpp = {OURS: (ROSCPP, OURS), ROSCPP: (ROSCPP, ROSCPP), ROSPY: (ROSCPP, ROSPY)}
    three_times = (lambda ratio: ratio >= 3, ">= 3 x rospy")
    no_slower = (lambda ratio: ratio <= 1, "<= rospy (None)")
    floats = ("msg/s", "sub", "pub", False, RATE)
    images = ("MB/s", "imgsub", "imgpub", False, BANDWIDTH)
    trip = ("us", "echo", "ping", True)
    calls = ("calls/s", "srv", "call", True, CALLS)
    new, kept = dict.fromkeys(ALONE, "0"), dict.fromkeys(ALONE, "1")
    return [
        Work("Float64 to itself, queue 1000", *floats, ALONE, SAME, ROSCPP, ABOVE),
        Work("Float64 from roscpp", *floats, to_ours, SAME, ROSCPP),
        Work("Float64 to roscpp", *floats, to_roscpp, SAME, ROSCPP),
        Work("images of 1 MB", *images, ALONE, IMAGES, ROSPY, three_times, 1_000_000),
        Work("images of 6.2 MB", *images, ALONE, IMAGES, ROSPY, None, 6_220_800),
        Work("round trip, median", *trip, P50, ALONE, BEST, ROSPY, no_slower),
        Work("round trip, 99 %", *trip, P99, ALONE, BEST, ROSPY),
        Work("service calls, new connection", *calls, ALONE, new, ROSPY),
        Work("service calls, persistent", *calls, ALONE, kept, ROSPY),
    ]


def import_path(folder: Path) -> str:
    """What the stock interpreter needs on PYTHONPATH for pyros1: its source, and defusedxml from this environment."""
    spec = importlib.util.find_spec("defusedxml")
    if spec is None or spec.origin is None:
        raise SystemExit("ERROR: defusedxml is not installed here; pip install pyros1 or defusedxml")
    folder.mkdir()
    (folder / "defusedxml").symlink_to(Path(spec.origin).parent)
    return f"{SOURCE}{os.pathsep}{folder}"


def measure(master: Master, work: Work, column: str, seconds: float, path: str) -> float:
    """Run one pair of programs once and return the figure."""
    first, second = work.pairs[column]
    extra = [str(work.size)] if work.size else []

    def start(kind: str, role: str, duration: float) -> Process:
        command = [*PROGRAMS[kind], role, work.queues[kind], str(duration), *extra]
        return master.run(command, label=f"{kind} {role}", PYTHONPATH=path if kind == OURS else None)

    mark = len(master.processes)
    try:
        waiting = start(first, work.waiting, seconds)
        waiting.wait_line("^ready", timeout=30)
        acting = start(second, work.acting, seconds if work.figures_from_acting else seconds + 30)
        talking = acting if work.figures_from_acting else waiting
        return float(talking.wait_line(work.pattern, timeout=seconds + 30)[1])
    finally:
        master.close_since(mark)


def ratio(work: Work) -> float:
    """Ours over the compared column, medians."""
    other = statistics.median(work.values[work.against])
    return statistics.median(work.values[OURS]) / other if other else float("inf")


def cell(values: list[float]) -> str:
    """Median, and the range when there are several runs."""
    middle = f"{statistics.median(values):,.0f}"
    return f"{middle} ({min(values):,.0f}..{max(values):,.0f})" if len(values) > 1 else middle


def table(done: list[Work]) -> str:
    """The table as Markdown, columns aligned."""
    rows = [["work", "unit", OURS, ROSCPP, ROSPY, "ratio", "goal", "met"]]
    for work in done:
        share = ratio(work)
        goal, met = (work.goal[1], "yes" if work.goal[0](share) else "NO") if work.goal else ("", "")
        cells = [cell(work.values[column]) for column in (OURS, ROSCPP, ROSPY)]
        rows.append([work.name, work.unit, *cells, f"{share:.2f} x {work.against}", goal, met])
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    padded = [[text.ljust(width) for text, width in zip(row, widths, strict=True)] for row in rows]
    lines = ["| " + " | ".join(row) + " |" for row in padded]
    lines.insert(1, "|" + "|".join("-" * (width + 2) for width in widths) + "|")
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="one short run of each: shows that it works, no more")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all single figures to FILE")
    parser.add_argument("--runs", type=int, metavar="N", help="runs of each (5; with --quick 1)")
    parser.add_argument("--seconds", type=float, metavar="S", help="length of a run (3; with --quick 1)")
    parser.add_argument("--only", default="", metavar="WORDS", help="only the lines whose name contains this")
    options = parser.parse_args()
    missing = missing_stock()
    if missing:
        print(f"ERROR: {missing}", file=sys.stderr)
        return 3
    runs = options.runs or (1 if options.quick else 5)
    seconds = options.seconds or (1.0 if options.quick else 3.0)
    chosen = [work for work in works() if options.only in work.name]
    with tempfile.TemporaryDirectory() as home:
        path = import_path(Path(home) / "import")
        master = Master("stock", Path(home) / "ros", free_port())
        try:
            master.start()
            for turn in range(runs):
                for work in chosen:
                    for column in work.pairs:
                        print(f"run {turn + 1} of {runs}: {work.name}, {column}", file=sys.stderr)
                        work.values.setdefault(column, []).append(measure(master, work, column, seconds, path))
        finally:
            master.close()
    print(table(chosen))
    if options.json:
        figures = {work.name: {"unit": work.unit, **work.values} for work in chosen}
        about = {"python": platform.python_version(), "machine": platform.machine(), "seconds": seconds}
        options.json.write_text(json.dumps({"about": about, "figures": figures}, indent=1) + "\n", encoding="utf-8")
    return 0 if all(work.goal is None or work.goal[0](ratio(work)) for work in chosen) else 1


if __name__ == "__main__":
    sys.exit(main())
