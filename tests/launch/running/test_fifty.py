"""Fifty nodes that crash, respawn, fork and do not listen: one Ctrl-C ends them all, and nothing is left (X87-X90).

Feature: no process is left over when a launch ends or is killed -- crashes, respawns, nodes that ignore signals
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parents[3] / "src"
DEADLINE = 60.0
PACKAGE = """<package format="2"><name>many</name><version>1.0.0</version><description>Nodes.</description>
<maintainer email="a@example.org">a</maintainer><license>BSD</license></package>"""
NODES = {
    "quiet": (38, "", "echo up; exec sleep 1000"),
    "crash": (4, "", "exit 3"),
    "again": (
        4,
        'respawn="true"',
        'echo x >> "$ROS_HOME/$1"; if [ $(wc -l < "$ROS_HOME/$1") -lt 3 ]; then exit 1; fi; echo up; exec sleep 1000',
    ),
    "fork": (2, "", "sleep 1000 & sleep 1000 & echo up; wait"),
    "leave": (1, "", "(trap '' INT TERM; exec sleep 1000) & echo up; exit 0"),
    "stuck": (1, "", "trap '' INT TERM; echo up; while :; do sleep 1000 & wait; done"),
}


def left(mark: str) -> list[str]:
    """The command lines of all processes that have the mark in their environment."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if mark.encode() in (folder / "environ").read_bytes():
                found.append((folder / "cmdline").read_bytes().replace(b"\0", b" ").decode())
        except OSError:
            continue
    return found


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="needs /proc")
def test_one_ctrl_c_ends_fifty_nodes(tmp_path: Path, free_port: int) -> None:
    package = tmp_path / "many"
    package.mkdir()
    (package / "package.xml").write_text(PACKAGE)
    lines = []
    for kind, (count, attributes, script) in NODES.items():
        (package / kind).write_text(f"#!/bin/sh\n{script}\n")
        (package / kind).chmod(0o755)
        for number in range(count):
            name = f"{kind}{number}"
            lines.append(f'<node pkg="many" type="{kind}" name="{name}" args="{name}" output="screen" {attributes}/>')
    assert len(lines) == 50
    (tmp_path / "many.launch").write_text("<launch>" + "\n".join(lines) + "</launch>")
    mark = f"PYROS1_TEST_MARK={tmp_path}"
    environ = {
        **os.environ,
        "PYTHONPATH": str(SOURCE),
        "ROS_HOME": str(tmp_path),
        "ROS_HOSTNAME": "localhost",
        "ROS_MASTER_URI": f"http://localhost:{free_port}",
        "ROS_PACKAGE_PATH": str(package),
        "PYROS1_TEST_MARK": str(tmp_path),
    }
    command = [sys.executable, "-m", "pyros1", "launch", "--sigint-timeout=4", "--sigterm-timeout=4", "many.launch"]
    with subprocess.Popen(
        command, cwd=tmp_path, env=environ, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as launcher:
        assert launcher.stdout is not None
        text, running, crashed = "", 0, 0
        while running < 46 or crashed < 4 + 4 * 2:
            line = launcher.stdout.readline()
            assert line, text
            text += line
            running += line == "up\n"
            crashed += "process has died" in line
        assert len(left(mark)) >= 46
        launcher.send_signal(signal.SIGINT)  # one Ctrl-C
        text += launcher.communicate(timeout=DEADLINE)[0]
        assert launcher.returncode == 0
    assert left(mark) == []
    assert text.count("restarting process") == 8 and text.endswith("done\n")
    # A shell lets what it starts in the background ignore SIGINT.
    assert set(re.findall(r"\[([a-z]+)\d-\d+\] escalating to SIGTERM", text)) == {"stuck", "leave", "fork"}
    assert set(re.findall(r"\[([a-z]+)\d-\d+\] escalating to SIGKILL", text)) == {"stuck", "leave"}
