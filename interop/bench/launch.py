"""How long a launch of fifty nodes takes until all are registered, and from Ctrl-C until all have ended.

    python3 interop/bench/launch.py --side ours|stock [--kinds KIND...] [--nodes N]

Needs pyros1 and defusedxml on PYTHONPATH. The launcher starts its own master and the nodes; the master is asked every
10 ms who is registered. Nodes of the kind "light" are shell scripts that only register: that measures the launcher
and its master. Those of the kind "roscpp" are stock relays, those of the kind "python" are pyros1's, whoever launches
them, and "preloaded" are the same, which our launcher forks (``--preload``); those of the kind "own" are pyros1's or
rospy's, as the launcher is. Prints a JSON object: seconds by figure.
``... nodes alone`` is what the nodes' own processor time comes to if it is spread over all processors: no launcher can
be faster than that.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
import xmlrpc.client
from pathlib import Path

STOCK_PYTHON = "/usr/bin/python3"
KINDS = ("light", "roscpp", "python", "preloaded", "own")
DEADLINE = 120.0
UP, DOWN, ALONE = "start until all are registered", "Ctrl-C until all have ended", "nodes alone"

PACKAGE = """<package format="2"><name>bench_nodes</name><version>1.0.0</version><description>Nodes.</description>
<maintainer email="nobody@example.org">nobody</maintainer><license>BSD</license></package>
"""
# Registers as a subscriber of /in, in its own name, and waits for the end.
LIGHT = r"""#!/bin/bash
for word; do case $word in __name:=*) name=/${word#__name:=};; esac; done
at=${ROS_MASTER_URI#http://}; at=${at%/}
values=
for value in "$name" /in std_msgs/String http://localhost:9/; do
  values+="<param><value><string>$value</string></value></param>"
done
body="<?xml version='1.0'?><methodCall><methodName>registerSubscriber</methodName><params>$values</params></methodCall>"
exec 3<>"/dev/tcp/${at%:*}/${at#*:}"
head='POST /RPC2 HTTP/1.1\r\nHost: %s\r\nContent-Type: text/xml\r\nContent-Length: %d\r\n\r\n%s'
printf "$head" "$at" ${#body} "$body" >&3
read -r answer <&3
exec sleep 1000
"""
PYTHON = """#!{python}
import sys
sys.path[:0] = {path!r}
import pyros1
from pyros1.msgs.std_msgs.msg import String

with pyros1.Node("bench") as node:
    node.subscribe(sys.argv[1], String, print, queue_size=1)
    node.spin()
"""
ROSPY = f"""#!{STOCK_PYTHON}
import sys
import rospy
from std_msgs.msg import String

rospy.init_node("bench")
rospy.Subscriber(sys.argv[1], String, print, queue_size=1)
rospy.spin()
"""


def launch_file(kind: str, nodes: int) -> str:
    """A launch file of so many nodes of a kind."""
    pkg, script = ("topic_tools", "relay") if kind == "roscpp" else ("bench_nodes", kind)
    lines = [f'<node pkg="{pkg}" type="{script}" name="r{i}" args="/in{i} /out{i}"/>' for i in range(nodes)]
    return "\n".join(["<launch>", *lines, "</launch>\n"])


def make_package(folder: Path, side: str) -> None:
    """A package with the nodes that are in no other."""
    folder.mkdir()
    (folder / "package.xml").write_text(PACKAGE, encoding="utf-8")
    path = [part for part in os.environ.get("PYTHONPATH", "").split(os.pathsep) if part]
    python = PYTHON.format(python=STOCK_PYTHON, path=path)
    for name, text in (
        ("light", LIGHT),
        ("python", python),
        ("preloaded", python),
        ("own", python if side == "ours" else ROSPY),
    ):
        (folder / name).write_text(text, encoding="utf-8")
        (folder / name).chmod(0o755)


def registered(uri: str) -> int:
    """How many of the nodes the master knows as subscribers."""
    try:
        with xmlrpc.client.ServerProxy(uri) as master:
            _, subscribers, _ = master.getSystemState("/bench")[2]  # type: ignore[index, misc]
    except (OSError, xmlrpc.client.Error):
        return 0
    return len({node for _, nodes in subscribers for node in nodes if node.startswith("/r") and node != "/rosout"})


def processor_time(mark: str) -> float:
    """Seconds of processor time of the nodes of a launch, which have its folder on their command lines.

    Those that are forked have their server's command line and environment; the server counts as well.
    """
    total = 0
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            words = (folder / "cmdline").read_bytes().decode(errors="replace")
            node = mark in words and "__name:=r" in words and "__name:=rosout" not in words
            if node or (
                "launch.preload.server" in words and mark in (folder / "environ").read_bytes().decode(errors="replace")
            ):
                # Threads in nanoseconds: many a node does not even last for one tick of the usual account.
                total += sum(int((task / "schedstat").read_text().split()[0]) for task in folder.glob("task/*"))
    return total / 1e9


def measure(side: str, kind: str, nodes: int, folder: Path) -> dict[str, float]:
    """Launch once; return seconds.

    Args:
        side: whose launcher.
        kind: of the nodes.
        nodes: how many.
        folder: an empty one.
    """
    make_package(folder / "bench_nodes", side)
    file = folder / "many.launch"
    file.write_text(launch_file(kind, nodes), encoding="utf-8")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        uri = f"http://localhost:{probe.getsockname()[1]}"
    env = {**os.environ, "ROS_HOME": str(folder / "home"), "ROS_HOSTNAME": "localhost", "ROS_MASTER_URI": uri}
    env["ROS_PACKAGE_PATH"] = f"{folder / 'bench_nodes'}:/usr/share"
    env.pop("PYTHONDONTWRITEBYTECODE", None)  # stock's modules are compiled once and for all, too
    env.pop("ROS_LOG_DIR", None)  # what the nodes' command lines name is to be below ``folder``
    command = [STOCK_PYTHON, "-m", "pyros1", "launch"] if side == "ours" else ["roslaunch"]
    if side == "ours" and kind == "preloaded":
        command.append("--preload")
    if side != "ours":
        env.pop("PYTHONPATH", None)
    began = time.monotonic()
    with subprocess.Popen(
        [*command, str(file)], env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as child:
        try:
            while registered(uri) < nodes:
                if child.poll() is not None or time.monotonic() - began > DEADLINE:
                    raise SystemExit(f"{side}: the {kind} nodes did not come up")
                time.sleep(0.01)
            up = time.monotonic()
            used = processor_time(str(folder))
            child.send_signal(signal.SIGINT)
            child.wait(DEADLINE)
        finally:
            child.kill()
    return {UP: up - began, DOWN: time.monotonic() - up, ALONE: used / (os.cpu_count() or 1)}


def main() -> int:
    """Measure each kind once and print the figures."""
    parser = argparse.ArgumentParser(description="Launch time of many nodes.")
    parser.add_argument("--side", choices=["ours", "stock"], required=True)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument("--nodes", type=int, default=50)
    options = parser.parse_args()
    figures = {}
    for kind in options.kinds:
        with tempfile.TemporaryDirectory() as folder:
            found = measure(options.side, kind, options.nodes, Path(folder))
        figures.update({f"{kind} {what}": seconds for what, seconds in found.items()})
    print(json.dumps(figures))
    return 0


if __name__ == "__main__":
    sys.exit(main())
