"""The report for those who help: what it says, and what it must not say.

Feature: `wtf --report`: what someone needs to know to help you, without secrets
"""

from __future__ import annotations

import pytest

from pyros1.doctor.facts import REFUSED, Disk, Failure, Machine, NodeFacts, System
from pyros1.doctor.finding import ERROR, Finding
from pyros1.doctor.report import MAX_ROWS, format_report, versions, without_secrets
from pyros1.graph import Connection, SystemState


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("http://me:pass@robot:11311/", "http://...@robot:11311/"),
        ("ws://localhost:9090/?token=abc&x=1", "ws://localhost:9090/?token=...&x=1"),
        ("password=a b", "password=... b"),
        ("/data/me/ws:/data/me/.ros:/data/me", "~/ws:~/.ros:~"),
        ("/data/men/ws /data/me-2", "/data/men/ws /data/me-2"),
        ("/home/anna/ws", "/home/.../ws"),
        ("C:\\Users\\anna\\ws", "C:\\Users\\...\\ws"),
        ("/Users/anna", "/Users/..."),
        ("nothing", "nothing"),
    ],
)
def test_secrets_are_left_out(text: str, shown: str) -> None:
    assert without_secrets(text, "/data/me") == shown


def test_a_machine_without_a_home() -> None:
    for home in ("", "/"):
        assert without_secrets("/a/b", home) == "/a/b"


def test_versions_of_libraries() -> None:
    found = versions()
    assert found["rosbags"][0].isdigit()
    assert "defusedxml" in found


def test_the_machine_and_the_findings() -> None:
    machine = Machine(
        {"HOME": "/home/anna", "ROS_IP": "10.0.0.2", "PYROS1_TOKEN": "abc", "AWS_KEY": "def", "PATH": "/home/anna/bin"},
        resolved={"robot": None},
        disks=[Disk("/home/anna/.ros", 10**9, 2 * 10**9, True)],
    )
    findings = [Finding("no-master", ERROR, "no master\nanswers", "pyros1 core", ("a | b",))]
    text = format_report({"pyros1": "1.2"}, machine, None, {}, findings)
    assert "| pyros1 | 1.2 |" in text
    assert "| the name robot | has no address |" in text
    assert "| disk of ~/.ros | 1.0 of 2.0 GB free |" in text
    assert "| ROS_IP | 10.0.0.2 |" in text
    assert "| PATH | ~/bin |" in text
    assert "| PYROS1_TOKEN | ... |" in text
    assert "- **error** (no-master): no master\\nanswers\n  - a | b\n  - fix: pyros1 core" in text
    assert "No master responds." in text
    for secret in ("abc", "def", "anna"):
        assert secret not in text


def test_the_running_system() -> None:
    link = Connection(1, "/b", "o", "TCPROS", "/t", True)
    nodes = {
        "/a": NodeFacts("http://robot:1/", "robot", connections=[link], clock_offset=-1.5),
        "/b": NodeFacts("http://robot:2/", "robot", failure=Failure(REFUSED, "connection refused")),
    }
    state = SystemState({"/t": ["/a"]}, {"/t": ["/b"], "/u": ["/b"]}, {"/s": ["/a"], "/a/get_loggers": ["/a"]})
    text = format_report({}, Machine({}), System("http://robot:11311", state, nodes), {"/t": "std_msgs/String"}, [])
    assert "None." in text
    assert "| /a | http://robot:1/ | yes; its clock is -1.500 s off | 1 |" in text
    assert "| /b | http://robot:2/ | no: connection refused | 0 |" in text
    assert "| /t | std_msgs/String | /a | /b |" in text
    assert "| /u | ? |  | /b |" in text
    assert "| /s | /a |" in text
    assert "get_loggers" not in text


def test_a_large_system_is_cut_and_names_do_not_break_the_tables() -> None:
    nodes = {f"/n{number:04}": NodeFacts("http://h:1/", "h") for number in range(MAX_ROWS + 7)}
    state = SystemState({"/a|b\x1b[31m": ["/n0000"]}, {}, {})
    text = format_report({}, Machine({}), System("http://h:11311", state, nodes), {}, [])
    assert "... and 7 more." in text
    assert f"/n{MAX_ROWS - 1:04}" in text
    assert f"/n{MAX_ROWS:04}" not in text
    assert "| /a\\|b\\x1b[31m | ? | /n0000 |  |" in text
    assert "No services except those of loggers." in text
