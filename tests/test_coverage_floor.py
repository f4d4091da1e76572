"""coverage_floor: what a run of tests under coverage has reached, by room."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from coverage.exceptions import CoverageWarning

from .coverage_floor import FLOORS, Counts, measured, rooms, table

ROOT = Path(__file__).resolve().parents[1]


def test_files_count_for_the_rooms_that_have_floors() -> None:
    found = rooms(
        {
            "src/pyros1/__init__.py": Counts(1, 1, 0, 0),
            "src/pyros1/wire/a.py": Counts(10, 9, 4, 2),
            str(ROOT / "src/pyros1/wire/b.py"): Counts(10, 10, 0, 0),
            "src/pyros1/bag/info.py": Counts(20, 10, 2, 1),
            "src/pyros1/bag/format/files.py": Counts(10, 10, 2, 2),
            "src/pyros1_pytest.py": Counts(5, 0, 0, 0),
        }
    )
    assert found == {
        "bag/format": Counts(10, 10, 2, 2),
        "wire": Counts(20, 19, 4, 2),
    }


def test_a_room_under_its_floor_is_named() -> None:
    found = {"empty": Counts(), "tf": Counts(90, 90, 10, 5), "wire": Counts(80, 78, 20, 16)}
    text, failed = table(found, {"tf": 95, "wire": 95, "node": 95})
    assert failed == [
        "node: nothing was measured",
        "wire: 94.0 % of its statements and branches are reached, not 95 %",
    ]
    lines = [line.split() for line in text.splitlines()]
    assert lines[1] == ["empty", "100.0", "%", "100.0", "%", "100.0", "%"]
    assert lines[2] == ["tf", "100.0", "%", "50.0", "%", "95.0", "%", "95", "%"]
    assert lines[3] == ["wire", "97.5", "%", "80.0", "%", "94.0", "%", "95", "%"]


def test_every_floor_is_of_a_room() -> None:
    assert [room for room in FLOORS if not (ROOT / "src" / "pyros1" / room / "__init__.py").exists()] == []


@pytest.mark.slow
def test_what_coverage_has_recorded(tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text("import pyros1.values.angles\npyros1.values.angles.evaluate_angle('1 + pi')\n")
    words = [sys.executable, "-m", "coverage", "run", f"--data-file={tmp_path / 'data'}", str(program)]
    subprocess.run(words, cwd=ROOT, check=True)
    found = measured(tmp_path / "data", include="*/pyros1/values/angles.py")
    (counts,) = found.values()
    assert list(rooms(found)) == ["values"]
    assert 0 < counts.reached_statements < counts.statements and 0 < counts.reached_branches < counts.branches


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:unclosed database")  # coverage's, of the broken one
def test_copies_of_sources_and_broken_data_files_do_not_count(tmp_path: Path) -> None:
    copy = tmp_path / "src" / "pyros1" / "values"
    copy.mkdir(parents=True)
    module = copy / "gone.py"
    module.write_text("from pyros1.values import angles\nangles.evaluate_angle('1')\n")
    options = ["--rcfile=/dev/null", "--branch", "--parallel-mode", f"--data-file={tmp_path / 'data'}"]
    subprocess.run([sys.executable, "-m", "coverage", "run", *options, str(module)], cwd=ROOT, check=True)
    module.unlink()
    (tmp_path / "data.killed").write_bytes(b"SQLite format 3\0" + bytes(100))
    with pytest.warns(CoverageWarning, match="Couldn't use data file"):
        found = measured(tmp_path / "data")
    assert found["src/pyros1/values/angles.py"].reached_statements and all(path.startswith("src/") for path in found)


def test_without_data_every_floor_is_missed(tmp_path: Path) -> None:
    assert measured(tmp_path / "data") == {}
    assert len(table({}, FLOORS)[1]) == len(FLOORS)
