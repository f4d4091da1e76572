"""The main loop of recordings and snapshots: subscribes to new topics until a signal ends the command."""

from __future__ import annotations

import time
from collections.abc import Callable
from queue import Empty, SimpleQueue

from pyros1.bag.record.topics import TopicSearch
from pyros1.ground.errors import NodeShutdownError
from pyros1.ground.interrupts import install_handler
from pyros1.node import Node

_SEARCH_PERIOD = 1.0
_POLL_PERIOD = 0.1
_CLOCK_WARN_DELAY = 2.0


class StopSignal:
    """A request to end the command, made by a signal, the node's shutdown or `stop`. Replaces the node's signal
    handlers.

    Args:
        node: the node whose shutdown ends the command.
    """

    def __init__(self, node: Node) -> None:
        self._requests: SimpleQueue[None] = SimpleQueue()  # its put() is safe in signal handlers
        install_handler(lambda *_: self.stop())
        node.on_shutdown(self.stop)

    def stop(self) -> None:
        """Request the end of the command."""
        self._requests.put(None)

    def wait(self, seconds: float) -> bool:
        """Wait up to `seconds` for the request; return whether it was made."""
        try:
            self._requests.get(timeout=seconds)
        except Empty:
            return False
        self.stop()  # so that later calls return True, too
        return True


def subscribe_until_stopped(
    search: TopicSearch,
    stop_signal: StopSignal,
    subscribe: Callable[[str], object],
    report: Callable[[], object],
    is_finished: Callable[[], bool] = lambda: False,
) -> None:
    """Subscribe to topics as they appear, until the command ends.

    Args:
        search: finds the topics.
        stop_signal: ends this function.
        subscribe: called with each new topic.
        report: called about once a second.
        is_finished: returns whether nothing is left to do; called often.
    """
    search_at = 0.0
    while not is_finished():
        now = time.monotonic()
        if now >= search_at:
            search_at = now + _SEARCH_PERIOD
            try:
                for name in search.new_topics():
                    subscribe(name)
            except NodeShutdownError:
                return  # the node was asked to shut down
            report()
        if stop_signal.wait(_POLL_PERIOD):
            return


def wait_for_time(node: Node, stop_signal: StopSignal) -> bool:
    """Wait until simulated time has begun; return False if the end of the command is requested first."""
    started_at, has_warned = time.monotonic(), False
    while node.now().is_zero():
        if not has_warned and time.monotonic() - started_at > _CLOCK_WARN_DELAY:
            node.log.warn("/use_sim_time set to true and no clock published.  Still waiting for valid time...")
            has_warned = True
        if stop_signal.wait(_POLL_PERIOD):
            return False
    return True
