"""Shared by recordings and snapshots: they follow new topics until a signal ends them."""

from __future__ import annotations

import time
from collections.abc import Callable
from queue import Empty, SimpleQueue

from pyros1.bag.record.topics import TopicSearch
from pyros1.ground.errors import NodeShutdownError
from pyros1.ground.interrupts import catch
from pyros1.node import Node

_LOOK_TIME = 1.0
_STEP = 0.1
_VALID_TIME = 2.0


class Ending:
    """The end of the command: by a signal, with the node, or by itself. Replaces the node's signal handlers.

    Args:
        node: the node with which it ends.
    """

    def __init__(self, node: Node) -> None:
        self._ends: SimpleQueue[None] = SimpleQueue()  # a signal handler may put into it
        catch(lambda *_: self.come())
        node.on_shutdown(self.come)

    def come(self) -> None:
        """Cause the end."""
        self._ends.put(None)

    def wait(self, seconds: float) -> bool:
        """Wait for the end; return whether it has come."""
        try:
            self._ends.get(timeout=seconds)
        except Empty:
            return False
        self.come()  # for later calls
        return True


def follow(
    search: TopicSearch,
    ending: Ending,
    subscribe: Callable[[str], object],
    show: Callable[[], object],
    finished: Callable[[], bool] = lambda: False,
) -> None:
    """Subscribe to topics as they appear, until the end.

    Args:
        search: finds the topics.
        ending: the end.
        subscribe: called with each new topic.
        show: called about once a second.
        finished: returns whether nothing is left to do; called often.
    """
    look_at = 0.0
    while not finished():
        now = time.monotonic()
        if now >= look_at:
            look_at = now + _LOOK_TIME
            try:
                for name in search.new_topics():
                    subscribe(name)
            except NodeShutdownError:
                return  # the node was told to shut down
            show()
        if ending.wait(_STEP):
            return


def wait_for_time(node: Node, ending: Ending) -> bool:
    """Wait until simulated time has begun; return False if the end came before."""
    began, said = time.monotonic(), False
    while node.now().is_zero():
        if not said and time.monotonic() - began > _VALID_TIME:
            node.log.warn("/use_sim_time set to true and no clock published.  Still waiting for valid time...")
            said = True
        if ending.wait(_STEP):
            return False
    return True
