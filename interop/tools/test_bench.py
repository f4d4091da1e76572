"""The benchmarks' page, history and quick form (`interop/bench`). CI runs the quick form itself, see `tests/run`."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from harness import INTEROP

BENCH = INTEROP / "bench"
ABOUT = {"date": "2026-01-01", "commit": "abc", "python": "3.11", "cpu": "<fast>", "cores": 2, "system": "Linux"}
ABOUT |= {"runs": 2, "seconds": 1.0, "load": 0.5}


@pytest.fixture(autouse=True)
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The programs of the bench can be imported, and nothing of them stays."""
    before = set(sys.modules)
    monkeypatch.syspath_prepend(str(BENCH))
    yield
    for name in set(sys.modules) - before:
        if str(getattr(sys.modules[name], "__file__", "")).startswith(str(BENCH)):
            del sys.modules[name]


class Turn:
    """A step of the bench, for results by hand."""

    label = "by hand"

    def run(self, bench: Any) -> dict[str, float]:
        raise NotImplementedError


Figures = dict[str, list["float | None"]]


def measured(by_condition: dict[str, Figures], bound: float, less: bool = False) -> tuple[Any, Any]:
    """A row and its results with these figures per condition and column; None is a turn that failed."""
    from model import Goal, Row

    steps = {column: Turn() for column in by_condition["quiet"]}
    results = {
        condition: {
            steps[column]: [None if one is None else {"x": one} for one in turns] for column, turns in figures.items()
        }
        for condition, figures in by_condition.items()
    }
    goals = (Goal(bound, "roscpp"), Goal(1e-9, most=True)) if len(by_condition) > 1 else (Goal(bound, "roscpp"),)
    return Row("group", "a <row>", "ms", "x", steps, goals, less), results  # type: ignore[arg-type]


def reported(figures: Figures, bound: float, less: bool = False, **others: Figures) -> dict[str, Any]:
    """The report of one row with these figures per column on a quiet machine, and under other conditions."""
    from table import losses, row_report

    row, results = measured({"quiet": figures, **others}, bound, less)
    rows = [row_report(row, results[condition], condition) for condition in results]
    return {"about": ABOUT, "rows": rows, "losses": losses([row], results)}


class Reader(HTMLParser):
    """The texts and the elements of a page; wants each element to be closed."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.texts: list[str] = []
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self._open: list[str] = []
        self.feed(page)
        assert self._open == [], f"not closed: {self._open}"

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in ("meta", "line"):
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def test_ratios_of_turns_leave_out_those_that_failed() -> None:
    row = reported({"ours": [2.0, None, 8.0], "roscpp": [4.0, 5.0, 8.0]}, 1.5, less=True)["rows"][0]
    assert row["ratios"] == {"roscpp": [2.0, 1.0]}
    row = reported({"ours": [2.0, 3.0, 8.0], "roscpp": [4.0, 0.0, 8.0]}, 1.5)["rows"][0]
    assert row["ratios"] == {"roscpp": [0.5, 1.0]}


def test_the_page_shows_rows_goals_and_misses() -> None:
    from page import history_line, page

    report = reported({"ours": [10.0, 30.0], "roscpp": [10.0, 10.0]}, 4)
    first = json.loads(history_line(report))
    html = page(report, [first])
    seen = Reader(html)
    text = " ".join(seen.texts)
    assert "0 of 1 goals are met" in text
    assert "group: a <row>" in text and "goal >= 4 x roscpp" in text
    assert "<fast>" in text
    dots = [attributes for tag, attributes in seen.elements if tag == "circle"]
    bars = [attributes for tag, attributes in seen.elements if tag == "line" and "range" in (attributes["class"] or "")]
    goals = [attributes for tag, attributes in seen.elements if tag == "line" and "goal" in (attributes["class"] or "")]
    assert len(dots) == len(bars) == len(goals) == 1
    left, right = float(bars[0]["x1"] or 0), float(bars[0]["x2"] or 0)
    assert left < float(dots[0]["cx"] or 0) < right < float(goals[0]["x1"] or 0)
    assert not any(tag == "polyline" for tag, _ in seen.elements), "one run has no history"


def test_the_page_shows_earlier_runs() -> None:
    from page import history_line, page

    report = reported({"ours": [40.0, 60.0], "roscpp": [10.0, 10.0]}, 4)
    earlier = json.loads(history_line(reported({"ours": [10.0], "roscpp": [10.0]}, 4)))
    earlier["about"]["commit"] = "0ld"
    seen = Reader(page(report, [earlier, json.loads(history_line(report))]))
    assert "1 of 1 goals are met" in " ".join(seen.texts)
    [trend] = [attributes for tag, attributes in seen.elements if tag == "polyline"]
    (_, before), (_, after) = [map(float, point.split(",")) for point in (trend["points"] or "").split()]
    assert after < before, "better is higher"
    assert "0ld: 1.00, abc: 5.00" in seen.texts


def test_a_row_without_figures_is_shown_as_failed() -> None:
    from page import history_line, page

    report = reported({"ours": [None], "roscpp": [1.0]}, 4)
    text = " ".join(Reader(page(report, [json.loads(history_line(report))])).texts)
    assert "failed" in text and "no figure" in text


BUSY: dict[str, Figures] = {
    "quiet": {"ours": [10.0, 12.0], "roscpp": [20.0, 24.0], "rospy": [10.0, 11.0]},
    "busy": {"ours": [50.0, 60.0], "roscpp": [40.0, 30.0], "rospy": [70.0, 60.0]},
}


def test_a_row_under_two_conditions_is_one_line_with_the_figures_of_both() -> None:
    from table import table

    row, results = measured(BUSY, 0.5, less=True)
    heads, _, line, *below = table([row], results).splitlines()
    cells = dict(zip(heads.split("|"), line.split("|"), strict=True))
    cells = {head.strip(): cell.strip() for head, cell in cells.items()}
    assert cells["ours"].startswith("11 ") and cells["busy: ours"].startswith("55 ")
    assert (cells["vs roscpp"], cells["busy: vs roscpp"]) == ("2.00", "0.64")
    assert (cells["met"], cells["busy: met"]) == ("yes, NO", "yes"), (
        "a bound for our own figure holds on a quiet machine"
    )
    assert below == ["better than roscpp on a quiet machine, worse under 'busy': group: a <row>"]


def test_the_page_has_both_conditions() -> None:
    from page import history_line, page

    report = reported(BUSY["quiet"], 0.5, less=True, busy=BUSY["busy"])
    first = json.loads(history_line(report))
    assert set(first["rows"]) == {"group: a <row>", "group: a <row> [busy]"}
    seen = Reader(page(report, [first]))
    assert {"vs roscpp", "busy: vs roscpp", "2.00", "0.64", "a <row> [busy]"} <= set(seen.texts)
    assert any("worse under 'busy'" in text for text in seen.texts)
    assert len([tag for tag, _ in seen.elements if tag == "circle"]) == 4


@pytest.mark.parametrize(
    ("figures", "quick", "code"),
    [
        (BUSY, False, 1),  # the bound for our own figure
        (BUSY, True, 0),
        ({**BUSY, "busy": {**BUSY["busy"], "rospy": [None, 1.0]}}, True, 2),
    ],
)
def test_the_exit_code_counts_all_conditions(figures: dict[str, Figures], quick: bool, code: int) -> None:
    from run import exit_code

    row, results = measured(figures, 0.5, less=True)
    assert exit_code([row], results, quick) == code


def test_conditions_end_and_leave_nothing() -> None:
    from conditions import CONDITIONS

    limited = {"quota", "half", "quarter"}
    cores, groups, children = os.sched_getaffinity(0), Path("/proc/self/cgroup").read_text(), own_children()
    for name, condition in CONDITIONS.items():
        try:
            with pytest.raises(KeyError), condition():  # however the step ends
                assert len(own_children()) - len(children) == (len(cores) if name == "busy" else 0)
                assert len(os.sched_getaffinity(0)) == (1 if name == "pinned" else len(cores))
                assert (Path("/proc/self/cgroup").read_text() != groups) == (name in limited)
                raise KeyError
        except OSError as error:
            assert name in limited and str(error), "only root may make a control group"
        assert os.sched_getaffinity(0) == cores and Path("/proc/self/cgroup").read_text() == groups
        assert own_children() == children


def own_children() -> list[str]:
    return Path(f"/proc/self/task/{threading.get_native_id()}/children").read_text().split()


def test_a_condition_that_there_is_not_is_an_error() -> None:
    program = [sys.executable, str(BENCH / "run.py"), "--under", "quiet,lazy", "--list"]
    done = subprocess.run(program, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 2 and "no such condition: 'lazy'; there are quiet, busy, quota, pinned" in done.stderr


def test_a_history_that_is_none_is_an_error(tmp_path: Path) -> None:
    from page import read_history

    assert read_history(tmp_path / "none") == []
    for text in ("{}", "[]", "3", "nothing", '{"about": 3, "rows": {}}', '{"about": {"date": ""}, "rows": 1}'):
        file = tmp_path / "history"
        file.write_text('{"about": {"date": ""}, "rows": {}}\n' + text)
        with pytest.raises(ValueError, match="history:2: not a run"):
            read_history(file)


def test_the_quick_form_has_rows_of_nearly_all_groups() -> None:
    from rows import QUICK, all_rows

    names = {f"{row.group}: {row.name}": row.group for row in all_rows()}
    assert set(names) >= QUICK
    assert {names[name] for name in QUICK} >= set(names.values()) - {"launch", "bags", "memory"}
    program = [sys.executable, str(BENCH / "run.py"), "--quick", "--list"]
    told = subprocess.run(program, capture_output=True, text=True, check=True, timeout=60)
    listed = [line for line in told.stdout.splitlines() if not line.startswith(" ")]
    assert sorted(line.partition(" [")[0] for line in listed) == sorted(QUICK)


def test_a_machine_without_git(monkeypatch: pytest.MonkeyPatch) -> None:
    from table import commit

    monkeypatch.setenv("PATH", "")
    assert commit() == "?"


def test_the_quick_form_of_the_web_rows() -> None:
    """A row of each protocol has figures."""
    command = [sys.executable, str(BENCH / "web_bridges.py"), "--quick"]
    result = subprocess.run(command, check=False, text=True, capture_output=True, timeout=100, stdin=subprocess.DEVNULL)
    assert result.returncode == 0, result.stderr
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in result.stdout.splitlines()[2:]]
    assert [row[0] for row in rows] == [f"Float64, 500 Hz, {form}, 2 clients" for form in ("none", "foxglove", "page")]
    assert all(float(cell) > 0 for row in rows for cell in row[1:4])


def test_a_row_of_the_web_that_there_is_not() -> None:
    command = [sys.executable, str(BENCH / "web_bridges.py"), "--only", "pigeons"]
    result = subprocess.run(command, check=False, text=True, capture_output=True, timeout=100, stdin=subprocess.DEVNULL)
    assert result.returncode == 2 and "pigeons" in result.stderr
