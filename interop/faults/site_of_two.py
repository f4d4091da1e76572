"""A robot and a laptop with cables between them whose faults a test chooses, and the peers that run on them."""

from __future__ import annotations

import contextlib
import signal
import sys
import time
from pathlib import Path
from types import TracebackType

from harness import Peer
from hosts import Host, Network
from wires import Wires

HASTY = Path(__file__).resolve().parent / "hasty_peer.py"
TEXT = "std_msgs/String"
IMAGE = "sensor_msgs/Image"
WAIT = 60.0
"""Seconds that anything may take on a loaded machine."""


class Site:
    """Two hosts, and the cables between them; for a with statement.

    Attributes:
        robot, laptop: the hosts.
        wires: the cables.
    """

    def __init__(self) -> None:
        self._stack = contextlib.ExitStack()
        with contextlib.ExitStack() as stack:
            network = stack.enter_context(Network())
            self.robot, self.laptop = network.add("robot"), network.add("laptop")
            self.wires = stack.enter_context(Wires(self.robot, self.laptop))
            self._stack = stack.pop_all()

    def __enter__(self) -> Site:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for host in (self.robot, self.laptop):
            for process in host.processes:
                process.signal(signal.SIGKILL)  # many could not end in peace: their master is gone
        self._stack.close()


def hasty(host: Host, name: str, uri: str) -> Peer:
    """Start our peer, with keep-alive in seconds instead of minutes, and wait until its node is up."""
    peer = Peer(host.inside([sys.executable, str(HASTY), name]), host.environ(uri), f"hasty peer {name}")
    peer.kind = "pyros1"
    host.processes.append(peer)
    peer.name = peer.event("ready", timeout=WAIT)
    return peer


def linked(peer: Peer, topic: str, count: int) -> None:
    """Wait until the publisher or subscriber of a topic has that many connections."""
    end = time.monotonic() + WAIT
    while time.monotonic() < end:  # the peer itself does not wait as long
        peer.tell("linked", topic, count)
        if not peer.wait_line(rf"^(?:linked|(?P<no>timeout linked)) {topic} {count}$", timeout=WAIT)["no"]:
            return
    raise AssertionError(f"{peer.label} has not {count} connections on {topic}\n{peer.transcript()}")
