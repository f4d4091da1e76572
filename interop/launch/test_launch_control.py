"""Servers of running launches: ours answers as stock's does, and each side's client understands both (X92)."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any
from xmlrpc.client import ServerProxy

import pytest
from harness import free_port

from pyros1.ground.errors import Error
from pyros1.launch.running.control import Launch, Report, Status

SOURCES = Path(__file__).resolve().parents[2] / "src"
DEADLINE = 40.0
LAUNCH = """<launch>
  <node pkg="topic_tools" type="relay" name="relay" ns="g" args="/in /out"/>
  <node pkg="topic_tools" type="relay" name="boss" args="/in2 /out" required="true" output="screen"/>
  <node pkg="topic_tools" type="relay" name="again" args="/in3 /out" respawn="true" respawn_delay="60"/>
</launch>
"""
STOCK_CLIENT = """
import json, sys
from roslaunch.netapi import list_processes
print(json.dumps([[p.name, p.respawn_count, p.is_alive, p.roslaunch_uri] for p in list_processes([sys.argv[1]])]))
"""


@pytest.fixture
def env(tmp_path: Path) -> dict[str, str]:
    (tmp_path / "three.launch").write_text(LAUNCH)
    return {
        **os.environ,
        "ROS_HOME": str(tmp_path / "ros"),
        "ROS_HOSTNAME": "localhost",
        "ROS_PACKAGE_PATH": "/usr/share",
        "PYTHONUNBUFFERED": "1",
    }


@pytest.fixture
def start(env: dict[str, str], tmp_path: Path) -> Iterator[Callable[[str], str]]:
    """Return a function that starts a launcher, ``ours`` or ``stock``, and returns its server's URI."""
    processes: list[subprocess.Popen[str]] = []

    def begin(kind: str) -> str:
        words = [sys.executable, "-m", "pyros1", "launch"] if kind == "ours" else ["/usr/bin/roslaunch"]
        path = {"PYTHONPATH": str(SOURCES)} if kind == "ours" else {"PYTHONPATH": ""}
        more = {**path, "ROS_MASTER_URI": f"http://localhost:{free_port()}"}
        with (tmp_path / f"output of {kind}").open("w") as output:
            processes.append(
                subprocess.Popen(
                    [*words, "three.launch"], cwd=tmp_path, env={**env, **more}, stdout=output, stderr=output, text=True
                )
            )
        until = time.monotonic() + DEADLINE
        while True:
            text = Path(output.name).read_text()
            if text.count("started with pid") >= 5:  # the master and rosout, too
                return re.findall(r"started roslaunch server (http://[\w.]+:\d+/)", text)[0]
            assert time.monotonic() < until and processes[-1].poll() is None, text
            time.sleep(0.1)

    yield begin
    for process in processes:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(DEADLINE)
        finally:
            process.kill()


def wait_for(launch: Launch, fits: Callable[[dict[str, Status]], object]) -> dict[str, Status]:
    until = time.monotonic() + DEADLINE
    while True:
        found = {entry.node: entry for entry in launch.status()}
        if fits(found):
            return found
        assert time.monotonic() < until, found
        time.sleep(0.1)


@pytest.mark.parametrize("kind", ["ours", "stock"])
def test_our_client_understands_both(kind: str, start: Callable[[str], str], tmp_path: Path) -> None:
    with closing(Launch(start(kind))) as launch:
        three = {"/g/relay", "/boss", "/again"}  # a program that has just begun has no memory yet
        found = wait_for(launch, lambda nodes: all(name in nodes and nodes[name].memory for name in three))
        report: Report = launch.report()
        assert report.title == "three.launch" and report.uptime >= 0
        for node, required, respawn in (("/g/relay", False, False), ("/boss", True, False), ("/again", False, True)):
            entry = found[node]
            assert (entry.state, entry.required, entry.respawn, entry.starts) == ("running", required, respawn, 1)
            assert os.getpgid(entry.pid) == entry.pid and entry.memory > 0 and entry.cpu >= 0 and entry.uptime >= 0
            assert entry.log.startswith(str(tmp_path / "ros" / "log")), entry.log
            assert entry.log.endswith(f"/{entry.label.replace('/', '-')}")
            args = launch.info(entry.label)["args"]
            assert args[0] == "/usr/lib/topic_tools/relay" and args[-1] == f"__log:={entry.log}.log"
        os.kill(found["/again"].pid, signal.SIGKILL)
        again = wait_for(launch, lambda nodes: nodes["/again"].state == "waiting")["/again"]
        assert again.exit_code == -signal.SIGKILL
        os.kill(found["/g/relay"].pid, signal.SIGKILL)
        gone = wait_for(launch, lambda nodes: nodes["/g/relay"].state in ("died", "ended"))["/g/relay"]
        assert gone.state == "died" or kind == "stock"  # which tells nothing of the dead
        if kind == "ours":
            assert report.refusal == ""
            launch.request("start", "/again")
            wait_for(launch, lambda nodes: nodes["/again"].state == "running" and nodes["/again"].starts == 2)
            launch.request("restart", "/boss")
            wait_for(launch, lambda nodes: nodes["/boss"].state == "running" and nodes["/boss"].starts == 2)
            launch.request("stop", "/boss")  # required, but wanted
            wait_for(launch, lambda nodes: nodes["/boss"].state == "stopped")
        else:
            assert "stock roslaunch" in report.refusal
            with pytest.raises(Error, match="stock roslaunch"):
                launch.request("stop", "/boss")


def test_both_answer_alike(start: Callable[[str], str], env: dict[str, str]) -> None:
    ours, stock = answers(start("ours"), env), answers(start("stock"), env)
    assert ours["info"].keys() - stock["info"].keys() == {"cwd", "log_file"}
    # Ours does not know the package any more, and the run id is in the paths.
    assert stock["info"].keys() - ours["info"].keys() == {"package", "run_id"}
    for key in ("spawn_count", "name", "alive", "respawn", "respawn_delay", "required", "log_output"):
        assert ours["info"][key] == stock["info"][key], key
    assert [type(word) for word in ours["info"]["args"]] == [type(word) for word in stock["info"]["args"]]
    assert ours["info"]["env"]["ROS_NAMESPACE"] == stock["info"]["env"]["ROS_NAMESPACE"]
    # The master and rosout are processes of stock's launch, and threads of ours.
    own = {"master", "rosout-1"}
    assert ours["names"] == [name for name in stock["names"] if name not in own]
    assert ours["listed"] == [row for row in stock["listed"] if row[0] not in own]
    assert ours["none"] == stock["none"] == -1
    assert ours["pid"] == stock["pid"] == [1, "the pid", "the pid"]
    assert ours["children"] == stock["children"]


def answers(uri: str, env: dict[str, str]) -> dict[str, Any]:
    with ServerProxy(uri) as connection:
        server: Any = connection
        code, text, pid = server.get_pid()
        assert text == str(pid)
        done = subprocess.run(
            ["/usr/bin/python3", "-c", STOCK_CLIENT, uri],
            env={**env, "PYTHONPATH": ""}, capture_output=True, text=True, timeout=DEADLINE, check=True,
        )  # fmt: skip
        listed = json.loads(done.stdout)
        assert all(where == uri for *_, where in listed)
        _, _, names = server.get_node_names()
        label = next(name for name in names if name.startswith("g/relay"))
        return {
            "pid": [code, "the pid", "the pid"],
            "names": names,
            "listed": [row[:3] for row in listed],
            "info": server.process_info(label)[2],
            "none": server.process_info("none")[0],
            "children": server.list_children(),
        }
