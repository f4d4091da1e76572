"""Launchers and nodes of both kinds together: ours running stock nodes, stock roslaunch running ours (X83-X90)."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from harness import free_port

SOURCES = Path(__file__).resolve().parents[2] / "src"
DEADLINE = 40.0
LAUNCH = """<launch>
  <rosparam>{shared: {list: [1, 2.5, text]}}</rosparam>
  <group ns="g"><remap from="unused" to="used"/>
    <node pkg="topic_tools" type="relay" name="stock" args="/in /out"><env name="MARK" value="set"/></node>
    <node pkg="minimal_nodes" type="minimal_publisher" name="ours"><param name="rate" value="20.0"/><remap from="topic1" to="/in"/></node>
  </group>
</launch>
"""  # noqa: E501  as it would be written


@pytest.fixture
def env(tmp_path: Path) -> dict[str, str]:
    (tmp_path / "both.launch").write_text(LAUNCH)
    return {
        **os.environ,
        "ROS_HOME": str(tmp_path / "ros"),
        "ROS_HOSTNAME": "localhost",
        "ROS_MASTER_URI": f"http://localhost:{free_port()}",
        "PYTHONPATH": str(SOURCES),
        "ROS_PACKAGE_PATH": f"{SOURCES / 'pyros1' / 'packages' / 'minimal_nodes'}:/usr/share",
        # Our nodes say "env python3": it must be one that has pyros1's dependencies.
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
    }


@pytest.fixture(params=["ours", "stock"])
def launcher(request: pytest.FixtureRequest, env: dict[str, str], tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    words = [sys.executable, "-m", "pyros1", "launch"] if request.param == "ours" else ["/usr/bin/roslaunch"]
    if request.param == "stock":
        env = {**env, "PYTHONUNBUFFERED": "1"}  # it does not flush what it prints into a file
    with (tmp_path / "output").open("w") as output:
        process = subprocess.Popen(
            [*words, "both.launch"], cwd=tmp_path, env=env, stdout=output, stderr=output, text=True
        )
    yield process
    process.send_signal(signal.SIGINT)
    try:
        assert process.wait(DEADLINE) == 0
    finally:
        process.kill()
    text = (tmp_path / "output").read_text()
    pids = [int(pid) for pid in re.findall(r"process\[g/.*started with pid \[(\d+)\]", text)]
    assert len(pids) == 2, text
    assert not [pid for pid in pids if Path(f"/proc/{pid}").exists()], text
    for line in ("[g/ours-3] killing on exit", "[g/stock-2] killing on exit", "done"):
        assert line in text


def stock_tool(env: dict[str, str], *words: str) -> str:
    own = {**env, "PATH": os.environ["PATH"], "PYTHONPATH": ""}
    done = subprocess.run(
        [f"/usr/bin/{words[0]}", *words[1:]], env=own, capture_output=True, text=True, timeout=DEADLINE, check=False
    )
    return done.stdout


def test_both_kinds_of_nodes_run_and_talk(launcher: subprocess.Popen[str], env: dict[str, str], tmp_path: Path) -> None:
    deadline = time.monotonic() + DEADLINE
    while not {"/g/ours", "/g/stock"} <= set(stock_tool(env, "rosnode", "list").split()):
        assert time.monotonic() < deadline and launcher.poll() is None, (tmp_path / "output").read_text()
        time.sleep(0.2)
    assert stock_tool(env, "rostopic", "echo", "-n", "1", "/out").startswith("data: 0.")
    assert stock_tool(env, "rosparam", "get", "/shared/list") == "- 1\n- 2.5\n- text\n\n"
    assert stock_tool(env, "rosparam", "get", "/g/ours/rate").strip() == "20.0"
    text = (tmp_path / "output").read_text()
    (pid,) = re.findall(r"process\[g/stock-2\]: started with pid \[(\d+)\]", text)
    environ = dict(item.split("=", 1) for item in Path(f"/proc/{pid}/environ").read_text().split("\0") if "=" in item)
    assert (environ["ROS_NAMESPACE"], environ["MARK"], environ["ROS_MASTER_URI"].rstrip("/")) == (
        "/g",
        "set",
        env["ROS_MASTER_URI"],
    )
    words = Path(f"/proc/{pid}/cmdline").read_text().split("\0")[:-1]
    run_id = stock_tool(env, "rosparam", "get", "/run_id").strip()
    log = f"__log:={tmp_path}/ros/log/{run_id}/g-stock-2.log"
    assert words == ["/usr/lib/topic_tools/relay", "/in", "/out", "unused:=used", "__name:=stock", log]
    assert os.path.realpath(f"/proc/{pid}/cwd") == str((tmp_path / "ros").resolve())
    assert os.getpgid(int(pid)) == int(pid)
    uris = [
        name
        for name in stock_tool(env, "rosparam", "list").split()
        if name.startswith("/roslaunch/uris/host_localhost__")
    ]
    assert len(uris) == 1
