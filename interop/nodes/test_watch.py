"""Nodes of all client libraries die, hang, are replaced and come back; a node of ours that watches is told.

Feature: notification when a node dies, hangs, is replaced, comes back, or disappears with its machine --
    `node.watch(name, on_lost, on_found)`; also roscpp and rospy nodes; a master restart is not reported as a loss
"""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from harness import Master
from hosts import Network

from pyros1.node import Node

MASTERS = ("ours",)  # under stock's, a second roscpp node of a name sometimes ends, too
KINDS = ("roscpp", "rospy", "pyros1")
PATIENCE = 60.0


class News:
    """What a watch tells, in order."""

    def __init__(self) -> None:
        self.items: list[Any] = []
        self._changed = threading.Condition()

    def __call__(self, sighting: Any) -> None:
        with self._changed:
            self.items.append(sighting)
            self._changed.notify_all()

    def after(self, count: int) -> list[bool]:
        """Wait for that many news; whether the node was there in each."""
        with self._changed:
            assert self._changed.wait_for(lambda: len(self.items) >= count, PATIENCE), self.items
        return [sighting.alive for sighting in self.items]


@pytest.fixture
def watcher() -> Iterator[Callable[[Master], Node]]:
    """Makes a node in this process."""
    nodes: list[Node] = []

    def make(master: Master) -> Node:
        nodes.append(Node("watcher", environ=master.environ(), argv=[], handle_signals=False, rosout=False))
        return nodes[-1]

    yield make
    for node in nodes:
        node.shutdown()


@pytest.mark.parametrize("kind", KINDS)
def test_a_life(launcher: Master, watcher: Callable[[Master], Node], kind: str) -> None:
    news = News()
    name = f"watched_{kind}"
    watcher(launcher).watch(name, news, news, period=0.2, limit=6.0)
    first = launcher.ready_peer(kind, name)
    assert news.after(1) == [True] and news.items[0].pid == first.pid
    first.signal(signal.SIGSTOP)
    assert news.after(2) == [True, False] and "did not answer" in news.items[1].reason
    first.signal(signal.SIGCONT)
    assert news.after(3)[2] and news.items[2].reason == "it answers again"
    first.signal(signal.SIGKILL)
    assert news.after(4)[3] is False and "its port is closed" in news.items[3].reason
    second = launcher.ready_peer(kind, name)
    assert news.after(5)[4] and news.items[4].pid == second.pid
    third = launcher.ready_peer(kind, name)  # the master ends the second one
    assert news.after(7)[5:] == [False, True] and news.items[6].pid == third.pid
    assert third.quit() == 0
    assert news.after(8)[7] is False
    assert len(news.items) == 8


@pytest.mark.parametrize("kind", ["ours", "stock"])
def test_a_new_master_is_no_loss(
    own_master: Callable[[str], Master], watcher: Callable[[Master], Node], kind: str
) -> None:
    """Stock's nodes do not register again, and are there all the same."""
    master, news = own_master(kind), {name: News() for name in KINDS}
    master.start()
    node = watcher(master)
    watches = [node.watch(name, news[name], news[name], period=0.1, limit=10.0) for name in KINDS]
    peers = [master.ready_peer(name, name) for name in KINDS]
    for name in KINDS:
        news[name].after(1)
    master.stop()
    master.start()
    late = News()
    with node.watch("rosout", late, late, period=0.1, limit=10.0):
        assert late.after(1) == [True], "the new master has answered"
    assert all(watch.alive for watch in watches)
    for name, peer in zip(KINDS, peers, strict=True):
        assert news[name].after(1) == [True]
        peer.signal(signal.SIGKILL)
        assert news[name].after(2) == [True, False]


# A machine that vanishes ----------------------------------------------------------------------------------------------

_WATCHER = """
from pyros1.node import Node
with Node("watcher") as node:
    tell = lambda sighting: print("found" if sighting.alive else "lost", sighting.reason, flush=True)
    node.watch("far", tell, tell)
    print("ready", flush=True)
    node.spin()
"""


def test_a_machine_vanishes() -> None:
    """Nobody sends an end of the connections: no FIN, no RST."""
    with Network() as network:
        near, far = network.add("near"), network.add("far")
        uri = near.core()
        watcher = near.start([sys.executable, "-c", _WATCHER], near.environ(uri))
        watcher.wait_line("^ready", PATIENCE)
        peer = far.peer("roscpp", "far", uri)
        watcher.wait_line("^found", PATIENCE)
        network.cut(far)
        watcher.wait_line("^lost", PATIENCE)
        assert peer.child.poll() is None
        network.mend(far)
        watcher.wait_line("^found it answers again", PATIENCE)
