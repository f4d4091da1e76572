"""Runs a node's diagnostic tasks and publishes their results on /diagnostics."""

from __future__ import annotations

import threading
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from pyros1.diagnostics.status import ERROR, OK, Status
from pyros1.diagnostics.tasks import Task
from pyros1.ground.errors import Error
from pyros1.msgs.diagnostic_msgs.msg import DiagnosticArray

if TYPE_CHECKING:
    from pyros1.node import Node

UNSET_SUMMARY = (ERROR, "No message was set")
"""The level and message for a task that sets neither."""


class Updater:
    """Runs tasks periodically and publishes their results until the node shuts down.

    For each new task, "Node starting up" is published.

    Args:
        node: the node that publishes.
        hardware_id: identifies this piece of hardware, for example its serial number.
        period: the time between two runs in seconds; 0 to run the tasks only when `update` is called. The parameter
            ``~diagnostic_period`` takes precedence if it is set when the updater is created.
    """

    def __init__(self, node: Node, hardware_id: str = "", period: float = 1.0) -> None:
        self.hardware_id = hardware_id
        self._node = node
        self._lock = threading.RLock()
        self._tasks: dict[str, Task] = {}
        self._publisher = node.advertise("/diagnostics", DiagnosticArray)
        actual_period = node.params.get("~diagnostic_period", period)
        self._timer = node.timer(float(actual_period), lambda event: self.update()) if actual_period else None

    def add(self, name: str, task: Task) -> None:
        """Add a task, or replace the task with the same name.

        Args:
            name: a description of what the task checks.
            task: called with a `Status` to fill in. If it raises an exception, the status becomes an error with the
                message of the exception.
        """
        with self._lock:
            self._tasks[name] = task
        self._publish([self._make_status(name, OK, "Node starting up")])

    def remove(self, name: str) -> bool:
        """Remove a task. Return whether there was a task with this name."""
        with self._lock:
            return self._tasks.pop(name, None) is not None

    def update(self) -> None:
        """Run all tasks and publish their results now."""
        with self._lock:
            tasks = list(self._tasks.items())
        results = []
        for name, task in tasks:
            status = self._make_status(name, *UNSET_SUMMARY)
            status.hardware_id = self.hardware_id
            try:
                task(status)
            except Exception as error:  # noqa: BLE001  the other tasks must run
                status.summary(ERROR, f"{type(error).__name__}: {error}")
                self._node.log.error("the diagnostic task %s has failed: %r", name, error, throttle=60)
            results.append(status)
        self._publish(results)

    def broadcast(self, level: int, message: str) -> None:
        """Publish the same level and message for all tasks, for example before the node shuts down."""
        with self._lock:
            names = list(self._tasks)
        self._publish([self._make_status(name, level, message) for name in names])

    def close(self) -> None:
        """Stop running tasks and publishing."""
        if self._timer is not None:
            self._timer.shutdown()
        self._publisher.unregister()

    def _make_status(self, name: str, level: int, message: str) -> Status:
        return Status(level=level, name=f"{self._node.name[1:]}: {name}", message=message)

    def _publish(self, statuses: Iterable[Any]) -> None:
        array = DiagnosticArray(status=list(statuses))
        array.header.stamp = self._node.now()
        try:
            self._publisher.publish(array)
        except Error:
            if self._node.ok():
                raise
