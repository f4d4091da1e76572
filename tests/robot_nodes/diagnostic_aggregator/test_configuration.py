from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest
import yaml

from pyros1.msgs.diagnostic_msgs.msg import DiagnosticStatus
from pyros1.robot_nodes.diagnostic_aggregator.analyzers import AnalyzerGroup
from pyros1.robot_nodes.diagnostic_aggregator.configuration import AnalyzerFactory

ROBOT = """
computer:
  type: diagnostic_aggregator/AnalyzerGroup
  path: Computer
  analyzers:
    disk: {type: diagnostic_aggregator/GenericAnalyzer, path: Disk, contains: [Temp, Usage], num_items: 1, timeout: 3}
    cpu: {type: GenericAnalyzer, path: CPU, startswith: CPU, discard_stale: true}
drivers:
  type: diagnostic_aggregator/GenericAnalyzer
  path: Drivers
  find_and_remove_prefix: [imu_node, gps_node]
  remove_prefix: ekf
  expected: ekf
  name: ekf2
  regex: 'm\\d+'
silent: {type: diagnostic_aggregator/DiscardAnalyzer, path: none, regex: 'Joint.*'}
unused: {type: diagnostic_aggregator/IgnoreAnalyzer, contains: [Smart]}
"""


def make(specifications: object, report: Any = pytest.fail) -> AnalyzerGroup:
    return AnalyzerFactory(report).make_group("/", "", specifications, "/agg/analyzers", 100.0)


def test_the_analyzers_of_a_robot() -> None:
    group = make(yaml.safe_load(ROBOT))
    names = ["CPU 0", "HD Temp", "imu_node: ok", "gps_node", "ekf", "ekf2", "m12", "Joint 1"]
    for name in names:
        assert group.analyze(DiagnosticStatus(name=name), 100.0), name
    assert not group.analyze(DiagnosticStatus(name="Smart Battery"), 100.0)
    assert [status.name for status in group.report(100.0)] == [
        *("/Computer/CPU", "/Computer/CPU/CPU 0", "/Computer/Disk", "/Computer/Disk/HD Temp", "/Computer"),
        *("/Drivers", "/Drivers/", "/Drivers/2", "/Drivers/", "/Drivers/ok", "/Drivers/m12"),
    ]
    stale = {status.name: status.message for status in group.report(104.0)}
    assert (stale["/Computer/Disk"], stale["/Drivers"]) == ("Stale", "OK")
    assert "/Computer/CPU/CPU 0" in stale
    assert "/Computer/CPU/CPU 0" not in {status.name for status in group.report(106.0)}, "it is discarded"


GOOD: Mapping[str, Any] = {"type": "diagnostic_aggregator/GenericAnalyzer", "path": "A", "contains": "a"}


@pytest.mark.parametrize(
    ("specifications", "lines", "names"),
    [
        (None, ["has no analyzers that can be used"], ["/AnalyzerGroup"]),
        ({"a": 5, "b": GOOD}, ["/agg/analyzers/a has no type: set it to"], ["/A", "/a"]),
        ({"a": {**GOOD, "type": [1]}, "b": GOOD}, ["/agg/analyzers/a has no type: set it to"], ["/A", "/a"]),
        ({"a": {**GOOD, "type": "pr2/Motors"}, "b": GOOD}, ["a is ignored: there is no analyzer pr2/Motors"], ["/A"]),
        ({"a": {**GOOD, "path": 5}, "b": GOOD}, ["a is ignored: it has no path"], ["/A", "/a"]),
        ({"a": {**GOOD, "contains": []}, "b": GOOD}, ["it matches nothing: set one of find_and_re"], ["/A", "/a"]),
        ({"a": {**GOOD, "startswith": [1]}}, ["a/startswith must be a string or a list of strings, not [1]"], ["/A"]),
        ({"a": {**GOOD, "regex": "(("}}, ["a ignores the regular expression '((': missing )"], ["/A"]),
        ({"a": {**GOOD, "regex": "(a+)+$"}}, ["expression '(a+)+$': it could take hours"], ["/A"]),
        ({"a": {**GOOD, "timeout": "x"}}, ["a/timeout must be a number, not 'x': using 5.0"], ["/A"]),
        ({"a": {**GOOD, "timeout": 0, "discard_stale": True}}, ["a discards nothing"], ["/A"]),
        (
            {"g": {"type": "AnalyzerGroup", "path": "G", "analyzers": {"a": GOOD, "x": {}}}, "b": GOOD},
            ["/agg/analyzers/g/analyzers/x has no type", "g is ignored: not all of its analyzers can be used"],
            ["/A", "/g"],
        ),
    ],
)
def test_mistakes_are_reported_in_one_line(specifications: object, lines: list[str], names: list[str]) -> None:
    reported: list[str] = []
    group = make(specifications, reported.append)
    assert [status.name for status in group.report(100.0)] == names
    assert len(reported) == len(lines)
    assert all(line in text and "\n" not in text for line, text in zip(lines, reported, strict=True))


def test_groups_in_groups_without_end() -> None:
    specification: dict[str, Any] = dict(GOOD)
    for _ in range(60):
        specification = {"type": "diagnostic_aggregator/AnalyzerGroup", "analyzers": {"a": specification}}
    reported: list[str] = []
    make({"a": specification}, reported.append)
    assert "too many groups within groups" in reported[0]
