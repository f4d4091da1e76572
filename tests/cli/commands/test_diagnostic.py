"""diagnostic: the diagnostics of a robot's components (L202).

The stock tool, rosdiagnostic, is in no distribution that these tests run on: what is expected is written down here.

Feature: diagnostics in the terminal -- `pyros1 diagnostic`
"""

from __future__ import annotations

import json
from collections.abc import Callable
from datetime import datetime, timezone
from functools import partial
from typing import Any

import pytest

from pyros1 import Time
from pyros1.cli.commands import diagnostic
from pyros1.cli.running import run_command
from pyros1.msgs.diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

Run = Callable[..., tuple[int, str, str]]
STATUS = [
    DiagnosticStatus(2, "/Power", "Error", "", []),
    DiagnosticStatus(1, "/Power/Battery", "low", "b1", [KeyValue("voltage", "11.5"), KeyValue("cells", "3")]),
    DiagnosticStatus(2, "/Power/Charger", "not there", "", []),
    DiagnosticStatus(0, "/Motors", "OK", "m", []),
    DiagnosticStatus(3, "/Lidar", "silent", "", []),
]
MOMENT = datetime.fromtimestamp(5.5, timezone.utc).astimezone()
RULE, THIN = "=" * 69, "-" * 69


@pytest.fixture
def run(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, call_main: Any) -> Run:
    for key, value in environ.items():
        monkeypatch.setenv(key, value)
    monkeypatch.delenv("ROS_NAMESPACE", raising=False)
    return partial(call_main, partial(run_command, "diagnostic"))


@pytest.fixture
def robot(make_node: Callable[..., Any]) -> Any:
    message = DiagnosticArray(status=STATUS)
    message.header.stamp = Time(5, 500_000_000)
    node = make_node("aggregator")
    node.advertise("diagnostics_agg", DiagnosticArray, latch=True).publish(message)
    return node


def test_what_is_not_well_is_shown_the_worst_first_l202(run: Run, robot: Any) -> None:
    lines = ["[ STALE ] /Lidar - silent", "[ ERROR ] /Power/Charger - not there", "[ WARN  ] /Power/Battery - low"]
    around = [RULE, f"Diagnostics generated on: {MOMENT}", THIN, *lines, RULE, ""]
    assert run() == (0, "\n".join(around), "")
    assert run("--topic", "diagnostics_agg", "--nocolor") == (0, "\n".join(around), "")


def test_level_filter_and_detail_l202(run: Run, robot: Any) -> None:
    assert run("-l", "2", "--filter", "Power")[1].splitlines()[3:-1] == ["[ ERROR ] /Power/Charger - not there"]
    assert "[  OK   ] /Motors - OK\n" in run("--level", "0")[1] and "OK" not in run("-l", "warn")[1]
    detail = [
        "[ WARN  ] /Power/Battery - low",
        f"    timestamp:   {MOMENT}",
        "    hardware_id: b1",
        "    - voltage: 11.5",
        "    - cells: 3",
    ]
    assert run("-d", "--filter", "Batt")[1].splitlines()[3:-1] == detail


def test_json(run: Run, robot: Any) -> None:
    code, out, _ = run("--json", "--filter", "Battery")
    status = {"level": "warn", "name": "/Power/Battery", "message": "low", "hardware_id": "b1"}
    values = {"voltage": "11.5", "cells": "3"}
    assert code == 0 and json.loads(out) == {"stamp": 5.5, "status": [{**status, "values": values}]}


def end_at_the_first_line(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the first line that is printed end the command, as Ctrl-C does."""
    printed = print

    def ending(*words: Any, **options: Any) -> None:
        printed(*words, **options)
        raise KeyboardInterrupt

    monkeypatch.setattr("builtins.print", ending)


def test_where_else_to_look_is_said(
    run: Run, make_node: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    make_node("driver").advertise("diagnostics", DiagnosticArray, latch=True).publish(DiagnosticArray(status=STATUS))
    code, out, err = run("--topic", "/diagnostics", "-l", "error")
    assert (code, err) == (0, "") and out.count("ERROR") == 1
    end_at_the_first_line(monkeypatch)
    with pytest.raises(KeyboardInterrupt):
        run("--topic", "/nothing")
    said = "WARNING: topic [/nothing] does not appear to be published yet; these are published: /diagnostics\n"
    assert capsys.readouterr().err == said


def test_without_an_aggregator_the_diagnostics_of_all_nodes_are_shown(
    run: Run, make_node: Callable[..., Any], environ: dict[str, str]
) -> None:
    for number, name in enumerate(("motor", "lidar", "quiet")):
        publisher = make_node(name).advertise("diagnostics", DiagnosticArray, latch=True)
        publisher.publish(DiagnosticArray(status=[DiagnosticStatus(number, name, "text", "", [])]))
    code, out, err = run("-l", "0")
    assert code == 0 and [line for line in out.splitlines() if line.startswith("[")] == [
        "[ ERROR ] quiet - text",
        "[ WARN  ] lidar - text",
        "[  OK   ] motor - text",
    ]
    assert err == "nothing publishes /diagnostics_agg; showing what nodes publish on /diagnostics instead\n"
    make_node("aggregator").advertise("diagnostics_agg", DiagnosticArray, latch=True).publish(
        DiagnosticArray(status=[DiagnosticStatus(1, "/all", "summed up", "", [])])
    )
    code, out, err = run()
    assert (code, err) == (0, "") and "/all - summed up" in out


def test_following_prints_lines_only(
    run: Run, robot: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    end_at_the_first_line(monkeypatch)
    with pytest.raises(KeyboardInterrupt):
        run("-f", "-l", "3")
    assert capsys.readouterr().out == "[ STALE ] /Lidar - silent\n"


def test_colours_and_levels_that_do_not_exist() -> None:
    array = DiagnosticArray()
    one = [DiagnosticStatus(1, "n", "m", "", [])]
    assert list(diagnostic.status_lines(array, one, coloured=True)) == ["[ \x1b[93mWARN \x1b[0m ] n - m"]
    odd = [DiagnosticStatus(7, "n", "m", "", []), DiagnosticStatus(-1, "o", "m", "", [])]
    assert list(diagnostic.status_lines(array, odd, coloured=True)) == ["[ 7     ] n - m", "[ -1    ] o - m"]
    assert diagnostic.select_statuses([*odd, *one], -5) == [odd[0], one[0], odd[1]]


def test_what_is_not_understood_is_refused(run: Run) -> None:
    assert "'[' is not a regular expression" in run("--filter", "[")[2]
    code, _, err = run("-l", "eror")
    assert code == 2 and "did you mean 'error'?" in err
    for level in ("9", "4", "-1", "1.0", ""):
        code, out, err = run(f"--level={level}")
        assert (code, out) == (2, "")
        assert f"unknown level {level!r}; levels: 0 ok, 1 warn, 2 error, 3 stale\n" in err
    assert run("word")[0] == 2 and run("-h")[0] == 0


def test_without_a_master(run: Run, monkeypatch: pytest.MonkeyPatch, closed_port: int) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", f"http://localhost:{closed_port}")
    code, out, err = run()
    assert (code, out) == (1, "") and err.startswith("ERROR: Unable to communicate with master!\n")
