"""How long a launch of many nodes takes until all are registered: `pyros1 launch` beside stock roslaunch.

    python interop/bench/launch.py [--nodes N] [--runs R] [--only KIND]

Each launcher starts its own master and the same nodes. Those of the kind "light" are shell scripts that only register:
what is measured is the launcher with its master. Those of the kind "roscpp" are stock relays, each of which takes about
35 ms of a processor, whoever launches it. The master is asked every 30 ms who is registered. Prints medians in seconds,
from the start of the command to the last registration and from Ctrl-C to the end of the command, and the ratios. Exit
code: 0, or 1 if ours is not at least three times as fast to start the first kind, 3 without stock ROS.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import shutil
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import time
import xmlrpc.client
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2] / "src"
STOCK_PYTHON = "/usr/bin/python3"
GOAL = 3.0
DEADLINE = 120.0


PACKAGE = """<package format="2"><name>light_nodes</name><version>1.0.0</version><description>Nodes.</description>
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


def launch_file(kind: str, nodes: int) -> str:
    """A launch file of so many nodes of a kind."""
    pkg, script = ("topic_tools", "relay") if kind == "roscpp" else ("light_nodes", "light")
    lines = [f'<node pkg="{pkg}" type="{script}" name="r{i}" args="/in{i} /out{i}"/>' for i in range(nodes)]
    return "\n".join(["<launch>", *lines, "</launch>\n"])


def make_light_nodes(folder: Path) -> None:
    """A package with the light node."""
    folder.mkdir()
    (folder / "package.xml").write_text(PACKAGE, encoding="utf-8")
    (folder / "light").write_text(LIGHT, encoding="utf-8")
    (folder / "light").chmod(0o755)


def python_path(folder: Path) -> str:
    """What stock ROS's interpreter, which runs both launchers, needs to find pyros1 and what that depends on."""
    folder.mkdir()
    for name in ("defusedxml", "ruamel"):
        spec = importlib.util.find_spec(name)
        if spec is None or not spec.submodule_search_locations:
            raise SystemExit(f"ERROR: {name} is not installed here; pip install pyros1")
        (folder / name).symlink_to(next(iter(spec.submodule_search_locations)))
    return f"{SOURCE}{os.pathsep}{folder}"


def registered(uri: str) -> int:
    """How many of the nodes the master knows."""
    try:
        with xmlrpc.client.ServerProxy(uri) as master:
            _, subscribers, _ = master.getSystemState("/bench")[2]  # type: ignore[index, misc]
    except (OSError, xmlrpc.client.Error):
        return 0
    return len({node for _, nodes in subscribers for node in nodes if node.startswith("/r") and node != "/rosout"})


def measure(command: list[str], file: Path, nodes: int, extra: dict[str, str]) -> tuple[float, float]:
    """Launch once.

    Args:
        command: the launcher.
        file: what it launches.
        nodes: how many nodes that has.
        extra: environment variables.

    Returns:
        Seconds to the last registration, and from Ctrl-C to the end.
    """
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        uri = f"http://localhost:{probe.getsockname()[1]}"
    home = file.parent / f"home{time.monotonic_ns()}"
    env = {**os.environ, "ROS_HOME": str(home), "ROS_HOSTNAME": "localhost", "ROS_MASTER_URI": uri, **extra}
    began = time.monotonic()
    with subprocess.Popen(
        [*command, str(file)], env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as child:
        try:
            while registered(uri) < nodes:
                if child.poll() is not None or time.monotonic() - began > DEADLINE:
                    raise SystemExit(f"{command}: the nodes did not come up")
                time.sleep(0.03)
            up = time.monotonic()
            child.send_signal(signal.SIGINT)
            child.wait(DEADLINE)
        finally:
            child.kill()
    return up - began, time.monotonic() - up


def main() -> int:
    """Measure both, taking turns, and print the table."""
    parser = argparse.ArgumentParser(description="Launch time of many nodes, beside stock roslaunch's.")
    parser.add_argument("--nodes", type=int, default=50)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--only", choices=["light", "roscpp"])
    options = parser.parse_args()
    stock = shutil.which("roslaunch")
    if stock is None:
        print("stock roslaunch is not installed; run interop/setup", file=sys.stderr)
        return 3
    print(f"{options.nodes} nodes, median of {options.runs} runs                 pyros1     stock  ratio")
    ratios = []
    for kind in [options.only] if options.only else ["light", "roscpp"]:
        ours, theirs = compare(kind, options.nodes, options.runs, stock)
        for column, what in enumerate(("start until all are registered", "Ctrl-C until all have ended")):
            row = f"{kind:7} {what:32} {ours[column]:7.2f} s {theirs[column]:7.2f} s"
            print(f"{row} {theirs[column] / ours[column]:6.1f}", flush=True)
        ratios.append(theirs[0] / ours[0])
    return 0 if ratios[0] >= GOAL else 1


def compare(kind: str, nodes: int, runs: int, stock: str) -> list[tuple[float, float]]:
    """Return the median times of ours and of stock.

    Args:
        kind: of the nodes.
        nodes: how many.
        runs: how often.
        stock: the stock launcher.
    """
    times: list[list[tuple[float, float]]] = [[], []]
    with tempfile.TemporaryDirectory() as folder:
        file, package = Path(folder) / "many.launch", Path(folder) / "light_nodes"
        make_light_nodes(package)
        ours = [STOCK_PYTHON, "-m", "pyros1", "launch"]
        launchers = [(ours, python_path(Path(folder) / "libraries")), ([stock], "")]
        file.write_text(launch_file(kind, nodes), encoding="utf-8")
        for _ in range(runs):
            for (command, path), found in zip(launchers, times, strict=True):
                extra = {"ROS_PACKAGE_PATH": f"{package}:/usr/share", "PYTHONPATH": path}
                found.append(measure(command, file, nodes, extra))
    return [(statistics.median(up for up, _ in found), statistics.median(down for _, down in found)) for found in times]


if __name__ == "__main__":
    sys.exit(main())
