"""What bridges cost: time of the processor and memory, for the figures of a fleet in ``howto/sites.md``.

All sites are on this machine, each with a master of pyros1. Run it on an idle machine: `python interop/bridge/cost.py`
prints a table in two minutes; with ``--compare``, in four minutes, one that compares bridges with a relay of twenty
lines: what a message costs over TCP and zenoh alone.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import socket
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from pyros1.master.server import Master

SECONDS = 6.0


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
    """A process of this folder or of ``pyros1``."""

    def __init__(self, uri: str, *command: str) -> None:
        environ = {**os.environ, "ROS_MASTER_URI": uri, "ROS_HOSTNAME": "localhost", "ROS_HOME": "/tmp/pyros1_cost"}
        if command[0].endswith(".py"):
            command = (str(Path(__file__).with_name(command[0])), *command[1:])
        self.process = subprocess.Popen(
            [sys.executable, *command],
            env=environ,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )

    def tell(self, line: str) -> None:
        """Write a line to its input."""
        assert self.process.stdin
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def answer(self) -> str:
        """Return the next line of its output."""
        assert self.process.stdout
        return self.process.stdout.readline().strip()

    def cpu(self) -> float:
        """Return the processor time that its threads have used in seconds.

        The times in ``/proc/PID/stat`` would not do: many kernels only count what runs at each tick of their clock, at
        which sleeping programs like these often wake up.
        """
        tasks = Path(f"/proc/{self.process.pid}/task").iterdir()
        return sum(int((task / "schedstat").read_text().split()[0]) for task in tasks) / 1e9

    def memory(self) -> float:
        """Return its memory in MB, without what it shares with other programs."""
        text = Path(f"/proc/{self.process.pid}/smaps_rollup").read_text()
        return sum(int(line.split()[1]) for line in text.splitlines() if line.startswith("Private")) / 1000

    def close(self) -> None:
        """End it."""
        self.process.terminate()
        self.process.communicate(timeout=20)


class Fleet:
    """A base and robots that connect to it, or all to a router; relays may take the place of bridges."""

    def __init__(
        self, stack: contextlib.ExitStack, count: int, with_router: bool = False, with_relay: bool = False
    ) -> None:
        self._stack = stack
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            endpoint = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
        bridge = ("-m", "pyros1", "bridge")
        where = ("--to", endpoint) if with_router else ("--listen", endpoint)
        uri = self._master()
        self._bridges: dict[str, Process] = {}
        if with_router:
            self._bridges["router"] = self._start("", *bridge, "router", "--listen", endpoint)
        names = [f"robot{number}" for number in range(count)]
        words = (*bridge, "--site", "base", *where, "--take", "*:**", "--sites", *names)
        words = ("relay.py", "receive", endpoint) if with_relay else words
        self._bridges["base"] = self._start(uri, *words)
        self.publishers = []
        self._subscriber = self._start(uri, "user_node.py", "subscribe", *(f"/{name}/a" for name in names))
        for name in names:
            uri = self._master()
            words = (*bridge, "--site", name, "--to", endpoint, "--send", "/a")
            robot = self._start(uri, *(("relay.py", "send", endpoint) if with_relay else words))
            self._bridges.setdefault("robot", robot)
            self.publishers.append(self._start(uri, "user_node.py", "publish", "/a"))
        for publisher in self.publishers:
            assert publisher.answer() == "ready"
        time.sleep(3)

    def _master(self) -> str:
        master = Master(port=0, bind_host="127.0.0.1")
        master.start()
        self._stack.callback(master.stop)
        return master.uri

    def _start(self, uri: str, *command: str) -> Process:
        process = Process(uri, *command)
        self._stack.callback(process.close)
        return process

    def processes(self) -> dict[str, Process]:
        """Return the processes that are measured."""
        return {**self._bridges, "publisher": self.publishers[0], "subscriber": self._subscriber}

    def _count(self) -> int:
        self._subscriber.tell("")
        return int(self._subscriber.answer())

    def measure(self, load: Load | None) -> dict[str, float]:
        """Return the processor time of each process in seconds per second, and the messages that came per second."""
        before = {name: each.cpu() for name, each in self.processes().items()}
        came, start = self._count(), time.monotonic()
        if load is None:
            time.sleep(SECONDS)
        else:
            for publisher in self.publishers:
                publisher.tell(f"{load.size} {load.rate} {SECONDS}")
            for publisher in self.publishers:
                assert publisher.answer() == "done"
        time.sleep(0.5)
        took = time.monotonic() - start
        found = {name: (each.cpu() - before[name]) / took for name, each in self.processes().items()}
        return {**found, "messages": (self._count() - came) / took}


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
    """Yield the rows of the table that compares bridges with relays, each with the user's node at its side."""
    sides = (("robot", "publisher"), ("base", "subscriber"))
    costs: dict[tuple[Load, str, bool], list[float]] = {}
    for _ in range(ROUNDS):
        for with_relay in (False, True):
            with contextlib.ExitStack() as stack:
                fleet = Fleet(stack, 1, with_relay=with_relay)
                idle = fleet.measure(None)
                for load in COMPARED:
                    found = fleet.measure(load)
                    for name in itertools.chain(*sides):
                        cost = 1e6 * (found[name] - idle[name]) / max(1.0, found["messages"])
                        costs.setdefault((load, name, with_relay), []).append(cost)
    for load in COMPARED:
        cells = []
        for bridge, node in sides:
            user = statistics.median(costs[load, node, False] + costs[load, node, True])
            ours, relay = (statistics.median(costs[load, bridge, with_relay]) for with_relay in (False, True))
            cells += [f"{user:.0f}", f"{ours:.0f}", f"{relay:.0f}", f"{(user + ours) / (user + relay):.2f}"]
        yield [load.name, f"{load.rate:.0f}", *cells]


def main() -> None:
    """Print the tables."""
    if sys.argv[1:] == ["--compare"]:
        titles = ("publisher", "robot's bridge", "relay", "ratio", "subscriber", "base's bridge", "relay", "ratio")
        print("| µs per message |", " | ".join(("/s", *titles)), "|")
        print("|---|---|---|---|---|---|---|---|---|---|")
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
