"""What more costs: many nodes, topics and parameters at one master, many links of one node, a chain of relays.

::

    python interop/bench/scale.py [--quick] [--only PART ...] [--nodes N ...] [--each N] [--seconds S]
                                  [--json FILE] [--html FILE]

Parts: ``light`` (nodes that only speak XML-RPC, with five topics and fifty parameters each, at our master and at
rosmaster), ``nodes`` (pyros1's, many in a process, at both masters, with rosout), ``publisher`` (one with many
subscribers), ``subscriptions`` (one node with many), ``relays`` (a chain). Needs stock ROS and the built roscpp
programs (``interop/setup``). Masters and Python programs run on stock's interpreter. Costs per node are those of the
nodes that were added last: a cost that is flat stays the same from size to size. CPU is processor time as the kernel
counts it, which other load on the machine changes less than times.

--quick takes less than 20 s, without rosmaster in ``nodes`` and without stock's programs.
Exit code: 0, 2 if a part failed, 3 if stock ROS is not there.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path.insert(1, str(HERE.parent / "peers"))
sys.path.insert(2, str(HERE.parents[1] / "src"))

from harness import missing_stock  # noqa: E402  found through the path above
from model import OURS, ROSCPP, ROSPY  # noqa: E402
from scale_links import chain, one_node, one_publisher  # noqa: E402
from scale_master import PARAMETERS, Core, Row, crowds, light, running  # noqa: E402
from scale_nodes import TOPICS, raise_file_limit  # noqa: E402
from scale_page import page, tables  # noqa: E402
from steps import Bench, import_path  # noqa: E402
from table import about  # noqa: E402

PARTS = ("light", "nodes", "publisher", "subscriptions", "relays")
SIZES, QUICK_SIZES = [100, 250, 500, 1000], [20, 40]


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


class Runs:
    """What is measured, part by part.

    Args:
        options: the command line's.
        folder: an empty one.
    """

    def __init__(self, options: argparse.Namespace, folder: Path) -> None:
        self._quick: bool = options.quick
        self._seconds: float = options.seconds
        self._sizes: list[int] = options.nodes
        self._each: int = options.each
        self._folder = folder
        self._path = import_path(folder / "import")
        self._started = 0
        self._stock = [] if options.quick else ["stock"]

    def light(self) -> Iterator[Row]:
        for side in ("ours", "stock"):
            with running(self._core(side, rosout=False)) as core:
                yield from light(core, self._sizes)

    def nodes(self) -> Iterator[Row]:
        for side in ("ours", *self._stock):
            with running(self._core(side, rosout=True)) as core:
                yield from crowds(core, self._sizes, self._each, idle=0.5 if self._quick else 3.0)

    def publisher(self) -> Iterator[Row]:
        links = 50 if self._quick else 500
        yield from self._under_stock(lambda core, bench, kind: iter([one_publisher(core, bench, kind, links)]))

    def subscriptions(self) -> Iterator[Row]:
        count, idle = (100, 0.5) if self._quick else (1000, 3.0)
        yield from self._under_stock(lambda core, bench, kind: iter([one_node(core, bench, kind, count, idle)]))

    def relays(self) -> Iterator[Row]:
        count = 2 if self._quick else 10
        kinds = (OURS,) if self._quick else (OURS, "topic_tools")
        yield from self._under_stock(lambda core, bench, kind: chain(core, bench, kind, count), kinds)

    def _under_stock(
        self, measure: Callable[[Core, Bench, str], Iterator[Row]], kinds: tuple[str, ...] = (OURS, ROSCPP, ROSPY)
    ) -> Iterator[Row]:
        for kind in kinds[:1] if self._quick else kinds:
            with running(self._core("stock", rosout=True)) as core:
                bench = Bench(core, self._folder / f"import{self._started}", self._seconds)
                yield from measure(core, bench, kind)

    def _core(self, side: str, rosout: bool) -> Core:
        self._started += 1
        return Core(side, self._folder / f"ros{self._started}", self._path, rosout)


def measure(runs: Runs, parts: list[str]) -> tuple[list[Row], bool]:
    """Run the parts; return the rows, and whether any part failed."""
    rows: list[Row] = []
    failed = False
    for part in parts:
        began = time.monotonic()
        say(f"{part} ...")
        try:
            for row in getattr(runs, part)():
                rows.append(row)
                say(f"  {time.monotonic() - began:4.0f} s: " + " ".join(f"{key}={show(row[key])}" for key in row))
        except Exception as error:  # noqa: BLE001  whatever it was, the other parts are still wanted
            failed = True
            say(f"FAILED: {part}\n{error}")
    return rows, failed


def show(value: Any) -> str:
    return f"{value:.2f}" if isinstance(value, float) else str(value)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=(__doc__ or "").partition("\n")[0],
        epilog=f"A node has {TOPICS} topics and, in the part light, {PARAMETERS} parameters.",
    )
    parser.add_argument("--quick", action="store_true", help="small numbers, ours only (but for rosmaster), under 20 s")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS), metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--nodes", nargs="+", type=int, metavar="N", help="numbers of nodes (100 250 500 1000)")
    parser.add_argument("--each", type=int, metavar="N", help="nodes in a process, of which N are multiples (50)")
    parser.add_argument("--seconds", type=float, metavar="S", help="length of what is repeated (4; with --quick 0.5)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write every figure to FILE")
    parser.add_argument("--html", type=Path, metavar="FILE", help="write a page with plots to FILE")
    options = parser.parse_args()
    options.nodes = options.nodes or (QUICK_SIZES if options.quick else SIZES)
    options.each = options.each or (20 if options.quick else 50)
    options.seconds = options.seconds or (0.5 if options.quick else 4.0)
    if options.nodes != sorted(set(options.nodes)) or any(size % options.each for size in options.nodes):
        parser.error(f"--nodes takes growing multiples of {options.each} (see --each)")
    missing = missing_stock()
    if missing:
        say(f"ERROR: {missing}")
        return 3
    raise_file_limit()
    with tempfile.TemporaryDirectory() as folder:
        rows, failed = measure(Runs(options, Path(folder)), options.only)
    report = {"about": about(1, options.seconds), "rows": rows}
    print(tables(rows))
    if options.json:
        options.json.write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
    if options.html:
        options.html.write_text(page(report), encoding="utf-8")
    return 2 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
