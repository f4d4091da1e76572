"""twist_mux: passes the command with the highest priority on to cmd_vel_out (https://wiki.ros.org/twist_mux).

When the source that drives the robot falls silent or is locked, a zero twist is published once, unless another source
takes over; with stock, the robot must notice this itself. Commands that are not finite are dropped.
"""

from __future__ import annotations

import threading
from functools import partial
from typing import Any

from pyros1.diagnostics import OK, Status, Updater
from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.std_msgs.msg import Bool
from pyros1.node import Node
from pyros1.robot_nodes.shared.node_clock import NodeClock, check_regularly
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.program import run_node
from pyros1.robot_nodes.shared.twist_sources import Source, read_sources
from pyros1.robot_nodes.shared.twists import TwistOutput, is_finite
from pyros1.robot_nodes.twist_mux.arbiter import Arbiter

CHECK_PERIOD = 0.05
"""Seconds between checks of whether the robot must be stopped."""
MAX_PRIORITY = 255


class TwistMux:
    """Subscribes to the topics and locks in the parameters, and publishes commands on cmd_vel_out.

    Args:
        node: the node.

    Raises:
        SourceError: the parameters cannot be used.
    """

    def __init__(self, node: Node) -> None:
        values = PrivateParameters.of(node)
        self._node = node
        self._clock = NodeClock(node)
        topics, locks = (
            [] if values.value(name) is None else read_sources(values.value(name), f"{node.name}/{name}", MAX_PRIORITY)
            for name in ("topics", "locks")
        )
        self._arbiter = Arbiter(topics, locks)
        if not self._arbiter.topics:
            node.log.error("the parameter %s/topics is not set, so nothing can drive the robot", node.name)
        self._lock = threading.Lock()
        self._output = TwistOutput(node, "cmd_vel_out")
        for index, topic in enumerate(self._arbiter.topics):
            node.subscribe(topic.topic, Twist, partial(self._command, index), queue_size=1)
        for index, lock in enumerate(self._arbiter.locks):
            node.subscribe(lock.topic, Bool, partial(self._switch, index), queue_size=1)
        check_regularly(node, CHECK_PERIOD, self._check)
        self._diagnostics = Updater(node, "none")
        self._diagnostics.add("Twist mux status", self._diagnose)

    def _command(self, index: int, twist: Any) -> None:
        if not is_finite(twist):
            topic = self._node.resolve(self._arbiter.topics[index].topic)
            self._node.log.error("dropped a command on %s, since it is not finite", topic, throttle=10)
            return
        with self._lock:
            if self._arbiter.command(index, self._clock.seconds()):
                self._output.publish(twist)

    def _switch(self, index: int, message: Any) -> None:
        with self._lock:
            self._arbiter.lock(index, message.data, self._clock.seconds())
        self._check()

    def _check(self) -> None:
        with self._lock:
            if self._arbiter.must_stop(self._clock.seconds()):
                self._output.stop()

    def _diagnose(self, status: Status) -> None:
        with self._lock:
            now, arbiter = self._clock.seconds(), self._arbiter
            status.summary(OK, "ok")
            for index, topic in enumerate(arbiter.topics):
                state = "masked" if arbiter.is_masked(index, now) else "unmasked"
                status.add(f"velocity {topic.name}", _describe(state, topic))
            for index, lock in enumerate(arbiter.locks):
                state = "locked" if arbiter.is_locked(index, now) else "free"
                status.add(f"lock {lock.name}", _describe(state, lock))
            status.add("current priority", arbiter.locked_priority(now))
            status.add("data age in [sec]", round(arbiter.age(now), 3))


def _describe(state: str, entry: Source) -> str:
    return f"{state} (listening to {entry.topic} @ {entry.timeout:f}s with priority #{entry.priority})"


def main(argv: list[str]) -> int:
    """Run twist_mux; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "twist_mux", TwistMux)
