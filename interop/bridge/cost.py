"""What bridges cost: time of the processor and memory, for the figures of a fleet in ``howto/sites.md``.

All sites are on this machine, each with a master of pyros1. Run it on an idle machine: `python interop/bridge/cost.py`
prints a table in two minutes.
"""

from __future__ import annotations

import contextlib
import json
import os
import socket
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pyros1
from pyros1.master.server import Master

SECONDS = 6.0
_TICKS = os.sysconf("SC_CLK_TCK")


class Load(NamedTuple):
    """What a robot sends: messages of so many bytes, and how many per second."""

    name: str
    size: int
    rate: float


LOADS = (
    Load("commands, 48 bytes", 48, 200.0),
    Load("scans, 6 kB", 6_000, 100.0),
    Load("images, 100 kB", 100_000, 30.0),
)
COMPARED = (*LOADS, Load("commands, 48 bytes", 48, 1000.0), Load("scans, 6 kB", 6_000, 500.0))


class Process:
    """A process of ``pyros1 bridge``, or of the relay that it is compared with."""

    def __init__(self, uri: str, *words: str, relay: bool = False) -> None:
        environ = {**os.environ, "ROS_MASTER_URI": uri, "ROS_HOSTNAME": "localhost"}
        what = [str(Path(__file__).with_name("relay.py"))] if relay else ["-m", "pyros1", "bridge"]
        command = [sys.executable, *what, *words]
        self.process = subprocess.Popen(command, env=environ, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)

    def cpu(self) -> float:
        """Return the processor time that it has used in seconds."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / _TICKS

    def memory(self) -> float:
        """Return its memory in MB, without what it shares with other programs."""
        text = Path(f"/proc/{self.process.pid}/smaps_rollup").read_text()
        return sum(int(line.split()[1]) for line in text.splitlines() if line.startswith("Private")) / 1000

    def close(self) -> None:
        """End it."""
        self.process.terminate()
        self.process.wait(20)


class Robot:
    """A site that sends what is published on /a."""

    def __init__(self, number: int, stack: contextlib.ExitStack, endpoint: str, with_relay: bool) -> None:
        self.name = f"robot{number}"
        self.master = Master(port=0, bind_host="127.0.0.1")
        self.master.start()
        stack.callback(self.master.stop)
        self.node = make_node(stack, self.master.uri)
        self.publisher: Any = self.node.advertise("/a", "std_msgs/String", queue_size=10)
        words = ("send", endpoint) if with_relay else ("--site", self.name, "--to", endpoint, "--send", "/a")
        self.bridge = Process(self.master.uri, *words, relay=with_relay)
        stack.callback(self.bridge.close)


def make_node(stack: contextlib.ExitStack, uri: str) -> pyros1.Node:
    """Return a node that ends with the stack."""
    environ = {"ROS_MASTER_URI": uri, "ROS_HOSTNAME": "localhost", "ROS_HOME": "/tmp/pyros1_cost"}
    node = pyros1.Node("user", argv=[], environ=environ, handle_signals=False)
    stack.callback(node.shutdown)
    return node


class Fleet:
    """A base and robots that connect to it, or all to a router; relays may take the place of bridges."""

    def __init__(
        self, stack: contextlib.ExitStack, count: int, with_router: bool = False, with_relay: bool = False
    ) -> None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            endpoint = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
        self.master = Master(port=0, bind_host="127.0.0.1")
        self.master.start()
        stack.callback(self.master.stop)
        self.router = Process("", "router", "--listen", endpoint) if with_router else None
        if self.router is not None:
            stack.callback(self.router.close)
        where = ("--to", endpoint) if with_router else ("--listen", endpoint)
        words = ("receive", endpoint) if with_relay else ("--site", "base", *where, "--take", "*:**")
        self.base = Process(self.master.uri, *words, relay=with_relay)
        stack.callback(self.base.close)
        self.robots = [Robot(number, stack, endpoint, with_relay) for number in range(count)]
        self.received = 0
        self.node = make_node(stack, self.master.uri)
        for robot in self.robots:
            self.node.subscribe(f"/{robot.name}/a", "std_msgs/String", self._count)
        for robot in self.robots:
            assert robot.publisher.wait_for_subscribers(1, 60), f"the bridge of {robot.name} does not send"
        time.sleep(3)

    def _count(self, _: Any) -> None:
        self.received += 1

    def processes(self) -> dict[str, Process]:
        """Return the processes that are measured."""
        found = {"robot": self.robots[0].bridge, "base": self.base}
        return found if self.router is None else {**found, "router": self.router}

    def measure(self, load: Load | None) -> dict[str, float]:
        """Return the processor time of each process in seconds per second, and the messages that came per second."""
        body = "x" * (load.size - 4) if load else ""
        before = {name: each.cpu() for name, each in self.processes().items()}
        came, start = self.received, time.monotonic()
        if load is None:
            time.sleep(SECONDS)
        else:
            for number in range(int(SECONDS * load.rate)):
                time.sleep(max(0.0, start + number / load.rate - time.monotonic()))
                for robot in self.robots:
                    robot.publisher.publish(body)
        time.sleep(0.5)
        took = time.monotonic() - start
        found = {name: (each.cpu() - before[name]) / took for name, each in self.processes().items()}
        return {**found, "messages": (self.received - came) / took}


def rows() -> Iterator[list[str]]:
    """Yield the rows of the table."""
    for count, with_router in ((1, False), (4, False), (4, True)):
        with contextlib.ExitStack() as stack:
            fleet = Fleet(stack, count, with_router)
            what = f"{count} robot{'s' * (count > 1)}{', a router' * with_router}"
            idle = fleet.measure(None)
            yield [what, "nothing", "", *(f"{100 * idle[name]:.1f} %" if name in idle else "" for name in WHO)]
            for load in LOADS:
                found = fleet.measure(load)
                cells = []
                for name in WHO:
                    per_message = found["messages"] / (count if name == "robot" else 1)
                    cost = (found.get(name, 0.0) - idle.get(name, 0.0)) / max(1.0, per_message)
                    cells.append(f"{1e6 * cost:.0f} µs" if name in found else "")
                yield [what, load.name, f"{found['messages']:.0f}", *cells]
            memory = {name: each.memory() for name, each in fleet.processes().items()}
            yield [what, "memory", "", *(f"{memory[name]:.0f} MB" if name in memory else "" for name in WHO)]


WHO = ("robot", "base", "router")
ROUNDS = 3


def comparison() -> Iterator[list[str]]:
    """Yield the rows of the table that compares bridges with relays."""
    costs: dict[tuple[Load, str, bool], list[float]] = {}
    for _ in range(ROUNDS):
        for with_relay in (False, True):
            with contextlib.ExitStack() as stack:
                fleet = Fleet(stack, 1, with_relay=with_relay)
                idle = fleet.measure(None)
                for load in COMPARED:
                    found = fleet.measure(load)
                    for name in WHO[:2]:
                        cost = 1e6 * (found[name] - idle[name]) / max(1.0, found["messages"])
                        costs.setdefault((load, name, with_relay), []).append(cost)
    for load in COMPARED:
        cells = []
        for name in WHO[:2]:
            bridge, relay = (statistics.median(costs[load, name, with_relay]) for with_relay in (False, True))
            cells += [f"{bridge:.0f} µs", f"{relay:.0f} µs", f"{bridge / relay:.2f}"]
        yield [load.name, f"{load.rate:.0f}", *cells]


def main() -> None:
    """Print the tables."""
    if sys.argv[1:] == ["--compare"]:
        print("| messages | /s | robot: bridge | relay | ratio | base: bridge | relay | ratio |")
        print("|---|---|---|---|---|---|---|---|")
        for row in comparison():
            print("|", " | ".join(row), "|", flush=True)
        return
    print("| sites | load of each robot | messages /s at the base | its bridge | the base's bridge | the router |")
    print("|---|---|---|---|---|---|")
    for row in rows():
        print("|", " | ".join(row), "|", flush=True)
    print(json.dumps({"cores": os.cpu_count(), "python": sys.version.split()[0]}))


if __name__ == "__main__":
    main()
