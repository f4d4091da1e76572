"""Prints how much of each room the tests reach; fails if a room is under its floor: ``coverage_floor.py DATA_FILE``.

tests/run calls it with the data file that it gave to ``coverage run``; each process appends something to its name.
A figure counts statements and branches, as coverage.py does: a branch is a jump that a line can make, and
it is reached when a test has made it.
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
SOURCES = "src/pyros1/"
FLOORS = {
    "wire": 96.0,
    "msgs": 95.0,
    "values": 96.5,
    "node": 96.5,
    "master": 96.5,
    "launch": 97.0,
    "bag/format": 98.0,
    "tf": 98.0,
}
"""Percent of the statements and branches of a room that tests must reach. The aim is 95 for each of them: raise it."""


@dataclass
class Counts:
    """What there is, and what of it was reached."""

    statements: int = 0
    reached_statements: int = 0
    branches: int = 0
    reached_branches: int = 0

    def add(self, other: Counts) -> None:
        """Add the counts of another file."""
        self.statements += other.statements
        self.reached_statements += other.reached_statements
        self.branches += other.branches
        self.reached_branches += other.reached_branches

    @property
    def percent(self) -> float:
        """Percent of the statements and branches that were reached."""
        return percent(self.reached_statements + self.reached_branches, self.statements + self.branches)


def percent(part: int, whole: int) -> float:
    """Return a part in percent; 100 of nothing."""
    return 100.0 * part / whole if whole else 100.0


def rooms(files: Mapping[str, Counts]) -> dict[str, Counts]:
    """Return the counts of each room that has a floor."""
    found: dict[str, Counts] = {}
    for path, counts in files.items():
        inside = path.replace("\\", "/").rpartition(SOURCES)[2]
        for name in (room for room in FLOORS if inside.startswith(f"{room}/")):
            found.setdefault(name, Counts()).add(counts)
    return dict(sorted(found.items()))


def table(found: Mapping[str, Counts], floors: Mapping[str, float]) -> tuple[str, list[str]]:
    """Return a table with a line per room, and a sentence for each room that is under its floor."""
    lines = [f"{'room':<16}{'statements':>12}{'branches':>12}{'both':>9}{'floor':>8}"]
    failed = [f"{room}: nothing was measured" for room in floors if room not in found]
    for room, counts in found.items():
        floor = floors.get(room)
        lines.append(
            f"{room:<16}{percent(counts.reached_statements, counts.statements):>10.1f} %"
            f"{percent(counts.reached_branches, counts.branches):>10.1f} %{counts.percent:>7.1f} %"
            f"{'' if floor is None else f'{floor:>6g} %'}"
        )
        if floor is not None and counts.percent < floor:
            failed.append(f"{room}: {counts.percent:.1f} % of its statements and branches are reached, not {floor:g} %")
    return "\n".join(lines), failed


def measured(data_file: Path, include: str = str(ROOT / SOURCES / "*")) -> dict[str, Counts]:
    """Return the counts of each module that matches a pattern; none if nothing was recorded.

    Data files that cannot be read, of processes that were killed while they wrote, are left out with a warning.
    """
    import coverage

    data_files = [str(path) for path in data_file.parent.glob(f"{data_file.name}.*")]
    if not data_files:
        return {}

    with tempfile.TemporaryDirectory() as folder:
        run = coverage.Coverage(data_file=str(Path(folder) / "combined"))
        run.combine(data_files, keep=True)
        report = Path(folder) / "report.json"
        run.json_report(outfile=str(report), include=[include])
        files: dict[str, Any] = json.loads(report.read_text())["files"]
    return {
        path: Counts(
            summary["num_statements"],
            summary["covered_lines"],
            summary.get("num_branches", 0),
            summary.get("covered_branches", 0),
        )
        for path, summary in ((path, each["summary"]) for path, each in files.items())
    }


def main(data_file: str) -> int:
    """Print the table; return 1 if a room is under its floor."""
    text, failed = table(rooms(measured(Path(data_file))), FLOORS)
    print(text)
    for sentence in failed:
        print(f"FAILED: coverage of {sentence}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
