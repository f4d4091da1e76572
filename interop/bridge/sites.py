"""Hosts with a master and a bridge each, in network namespaces, and the cables between them."""

from __future__ import annotations

import contextlib
import re
import signal
import sys
from pathlib import Path
from types import TracebackType
from typing import NamedTuple

from harness import STOCK_PYTHON, Peer, Process, until
from hosts import Host, Network
from wires import Wires

ENDS = str(Path(__file__).resolve().parent / "ends.py")
WAIT = 60.0
"""Seconds that anything may take on a loaded machine."""


class Message(NamedTuple):
    """A message that came: which one, and its age in seconds."""

    kind: str
    number: int
    age: float


class Sites:
    """Hosts named base, red and blue; base listens, and the others connect to it. For a with statement.

    Attributes:
        base, red, blue: the hosts.
        wires: the cables.
        bridges: the processes of the bridges, by the host's name.
    """

    def __init__(self) -> None:
        self.bridges: dict[str, Process] = {}
        self._uris: dict[str, str] = {}
        self._stack = contextlib.ExitStack()
        with contextlib.ExitStack() as stack:
            network = stack.enter_context(Network())
            self.base, self.red, self.blue = (network.add(name) for name in ("base", "red", "blue"))
            self.wires = stack.enter_context(Wires(self.base, self.red, self.blue))
            self._stack = stack.pop_all()

    def __enter__(self) -> Sites:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for host in (self.base, self.red, self.blue):
            for process in host.processes:
                process.signal(signal.SIGKILL)  # many could not end in peace: the network is bad
        self._stack.close()

    def start(self, host: Host, *words: str, core: str = "stock") -> None:
        """Start a master, unless there is one, and a bridge.

        Args:
            host: where.
            words: what the bridge sends and takes.
            core: whose master, ``stock`` or ``ours``.
        """
        if host.name not in self._uris:
            self._uris[host.name] = host.core(core)
        at = ("--listen", "tcp/0.0.0.0:7447") if host is self.base else ("--to", "tcp/base:7447")
        command = host.pyros1("bridge", "--site", host.name, *at, "--insecure", *words)
        self.bridges[host.name] = host.start(command, host.environ(self._uris[host.name]), "bridge")

    def peer(self, host: Host, kind: str, name: str) -> Peer:
        """Start a peer at a site."""
        return host.peer(kind, name, self._uris[host.name])

    def talk(self, host: Host, rate: float = 50, image_rate: float = 10, image_size: int = 20_000) -> Process:
        """Start stock's publisher of /small and /image, see ``ends.py``."""
        words = [STOCK_PYTHON, ENDS, "talk", str(rate), str(image_rate), str(image_size)]
        process = host.start(words, host.environ(self._uris[host.name], "stock"), "talker")
        process.wait_line("^ready", WAIT)
        return process

    def listen(self, host: Host, prefix: str) -> Process:
        """Start stock's subscriber of both, and wait for the first messages."""
        words = [STOCK_PYTHON, ENDS, "listen", prefix]
        process = host.start(words, host.environ(self._uris[host.name], "stock"), "listener")
        process.wait_line("^small", WAIT)
        return process

    def status(self, host: Host) -> str:
        """Return what ``bridge status`` prints at a site."""
        return host.run(host.pyros1("bridge", "status"), host.environ(self._uris[host.name])).output

    def await_present(self, host: Host, *others: str) -> None:
        """Wait until a site has found others."""
        until(
            lambda: all(f"{other}: present" in self.status(host) for other in others),
            f"{host.name} has found {', '.join(others)}",
            WAIT,
        )

    def is_published(self, host: Host, topic: str) -> bool:
        """Return whether a topic is published at a site."""
        words = [sys.executable, "-m", "pyros1", "topic", "list", "-p"]
        return topic in host.run(words, host.environ(self._uris[host.name])).output

    def await_topic(self, host: Host, topic: str) -> None:
        """Wait until a topic is published at a site."""
        until(lambda: self.is_published(host, topic), f"{topic} at {host.name}", WAIT)

    def slow_down(
        self, one: Host, other: Host, delay: float = 0.0, lost: float = 0.0, rate: float | None = None
    ) -> None:
        """Make the cable between two hosts bad, in both directions.

        Args:
            one, other: the hosts.
            delay: seconds that a packet takes.
            lost: share of packets that are lost.
            rate: bytes per second; None for no limit.
        """
        for path in self.wires.both_ways(one, other):
            path.delay, path.lost, path.rate, path.room = delay, lost, rate, 64_000


def parse(lines: list[str]) -> list[Message]:
    """Return the messages that a subscriber has printed, see ``ends.py``."""
    found = (re.fullmatch(r"(small|image) (\d+) (-?[\d.]+)", line) for line in lines)
    return [Message(match[1], int(match[2]), float(match[3])) for match in found if match]
