"""Nodes on another machine, through a real sshd on this one; pyros1 or stock ROS finds them there (X49-X54, X91).

Feature: nodes on other machines, over `ssh` -- with pyros1 or stock ROS there
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from harness import SOURCE, Process, free_port, until
from sshd import loopback_sshd

pytestmark = pytest.mark.ours_only

LAUNCH = """<launch>
  <machine name="far" address="robot" env-loader="{folder}/env.sh" timeout="20"/>
  <group ns="g">
    <node pkg="topic_tools" type="relay" name="far" args="/in /out" machine="far" respawn="true">
      <env name="MARK" value="two words"/>
    </node>
    <node pkg="topic_tools" type="relay" name="near" args="/out /back"/>
    <node pkg="shouting" type="shout" name="shout" machine="far" output="screen"/>
  </group>
</launch>
"""
PACKAGE = """<package format="2"><name>shouting</name><version>1.0.0</version><description>Nodes.</description>
<maintainer email="a@example.org">a</maintainer><license>BSD</license></package>"""
SHOUT = """#!/bin/sh
echo "from $(echo $SSH_CONNECTION | cut -d' ' -f1), home $ROS_HOME"
exec sleep 1000
"""
"""With exec, since Debian's shell may lose a Ctrl-C that arrives just before it forks."""


@pytest.fixture
def sshd(tmp_path: Path) -> Iterator[Path]:
    """A folder with an sshd that runs, and a client configuration for it."""
    with loopback_sshd(tmp_path):
        yield tmp_path


@pytest.fixture(params=["pyros1", "stock"])
def launch(request: pytest.FixtureRequest, sshd: Path) -> Iterator[Process]:
    """The launcher, with nodes on a machine where pyros1 or stock ROS is installed."""
    package = sshd / "shouting"
    package.mkdir()
    (package / "package.xml").write_text(PACKAGE)
    (package / "shout").write_text(SHOUT)
    (package / "shout").chmod(0o755)
    there = {"ROS_HOME": f"{sshd}/far_home", "ROS_HOSTNAME": "localhost", "ROS_PACKAGE_PATH": f"{package}:/usr/share"}
    (sshd / "bin").mkdir()
    if request.param == "pyros1":
        there["PYTHONPATH"] = str(SOURCE)
        (sshd / "bin" / "python3").write_text(f'#!/bin/sh\nexec {sys.executable} "$@"\n')
        (sshd / "bin" / "python3").chmod(0o755)
    exports = "".join(f"export {name}='{value}'\n" for name, value in there.items())
    (sshd / "env.sh").write_text(f'#!/bin/sh\n{exports}export PATH={sshd}/bin:$PATH\nexec "$@"\n')
    (sshd / "env.sh").chmod(0o755)
    (sshd / "far.launch").write_text(LAUNCH.format(folder=sshd))
    environ = {
        **os.environ,
        "PYTHONPATH": str(SOURCE),
        "PYROS1_SSH": f"ssh -F {sshd}/.ssh/config",
        "ROS_HOME": str(sshd / "near_home"),
        "ROS_HOSTNAME": "localhost",
        "ROS_MASTER_URI": f"http://localhost:{free_port()}",
        "ROS_PACKAGE_PATH": "/usr/share",
    }
    command = [sys.executable, "-m", "pyros1", "launch", "--sigint-timeout=20", str(sshd / "far.launch")]
    process = Process(command, environ, "launch")
    yield process
    process.close()


def started(launch: Process, name: str) -> int:
    return int(launch.wait_line(rf"process\[g/{name}-\d+\]: started with pid \[(\d+)\]", timeout=30)[1])


def gone(pid: int) -> bool:
    return not Path(f"/proc/{pid}").exists()


def test_remote_nodes_run_speak_and_end(launch: Process, sshd: Path) -> None:
    far = started(launch, "far")
    launch.wait_line(rf"from 127\.0\.0\.1, home {sshd}/far_home", timeout=30)
    environ = dict(item.split("=", 1) for item in Path(f"/proc/{far}/environ").read_text().split("\0") if "=" in item)
    assert environ["MARK"] == "two words" and environ["ROS_NAMESPACE"] == "/g" and "SSH_CONNECTION" in environ
    words = Path(f"/proc/{far}/cmdline").read_text().split("\0")[:-1]
    assert words[:-1] == ["/usr/lib/topic_tools/relay", "/in", "/out", "__name:=far"]
    assert re.fullmatch(rf"__log:={sshd}/far_home/log/[^/]+/g-far-\d+\.log", words[-1])
    os.kill(far, signal.SIGKILL)
    launch.wait_line(r"\[g/far-\d+\] restarting process", timeout=30)
    again = started(launch, "far")
    launch.signal(signal.SIGINT)
    assert launch.wait(60) == 0
    assert not launch.unread("escalating")
    until(lambda: gone(far) and gone(again), "nothing runs over there")


def test_status_and_a_connection_that_breaks(launch: Process, sshd: Path) -> None:
    far, shout = started(launch, "far"), started(launch, "shout")
    environ = dict(item.split("=", 1) for item in Path(f"/proc/{launch.pid}/environ").read_text().split("\0") if item)
    command = [sys.executable, "-m", "pyros1", "node", "status"]
    status = subprocess.run(command, env=environ, capture_output=True, text=True, timeout=30, check=True).stdout
    assert re.search(rf"^/g/far +running +{far} +[\d.]+ % +[\d.]+ MB +0 +0:\d\d:\d\d +far$", status, re.M), status
    children = [pid for file in Path(f"/proc/{launch.pid}/task").glob("*/children") for pid in file.read_text().split()]
    (ssh,) = (int(pid) for pid in children if Path(f"/proc/{pid}/comm").read_text() == "ssh\n")
    os.kill(ssh, signal.SIGKILL)
    launch.wait_line(r"ERROR: the connection to machine \[far\] \(robot\) was lost", timeout=30)
    until(lambda: gone(far) and gone(shout), "the nodes over there have ended", timeout=30)
    launch.wait_line(r"remote\[far\] connected to robot again", timeout=30)
    again = started(launch, "far")
    assert not gone(again)
    launch.signal(signal.SIGINT)
    assert launch.wait(60) == 0
    until(lambda: gone(again), "nothing runs over there")


def test_a_killed_launcher_leaves_nothing_over_there(launch: Process) -> None:
    pids = [started(launch, name) for name in ("far", "near", "shout")]
    launch.signal(signal.SIGKILL)
    until(lambda: all(map(gone, pids)), "nothing runs, here and over there", timeout=30)
