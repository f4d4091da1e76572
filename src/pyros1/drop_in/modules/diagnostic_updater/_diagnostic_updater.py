"""Tasks, and the Updater that runs them."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import rospy

from diagnostic_updater._diagnostic_status_wrapper import (
    ERROR,
    OK,
    WARN,
    DiagnosticStatus,
    DiagnosticStatusWrapper,
    KeyValue,
)
from pyros1.diagnostics.tasks import Combined
from pyros1.diagnostics.updater import UNSET
from pyros1.msgs.diagnostic_msgs.msg import DiagnosticArray

__all__ = [
    "ERROR",
    "OK",
    "WARN",
    "CompositeDiagnosticTask",
    "DiagnosticArray",
    "DiagnosticStatus",
    "DiagnosticStatusWrapper",
    "DiagnosticTask",
    "DiagnosticTaskVector",
    "FunctionDiagnosticTask",
    "KeyValue",
    "Updater",
]


class DiagnosticTask:
    """Base of all tasks.

    Args:
        name: of what the task looks at, for people.
    """

    def __init__(self, name: str) -> None:
        self.name = name

    def getName(self) -> str:
        """Return the name."""
        return self.name

    def run(self, stat: Any) -> Any:
        """Fill a status, and return it."""
        return stat


class FunctionDiagnosticTask(DiagnosticTask):
    """A task that calls a function with the status."""

    def __init__(self, name: str, fn: Callable[[Any], Any]) -> None:
        super().__init__(name)
        self.fn = fn

    def run(self, stat: Any) -> Any:
        """Call the function; it should return the status."""
        return self.fn(stat)


class CompositeDiagnosticTask(DiagnosticTask):
    """Several tasks in one status."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.tasks: list[Any] = []

    def run(self, stat: Any) -> Any:
        """Run all tasks, and merge their summaries."""
        Combined([task.run for task in self.tasks]).run(stat)
        return stat

    def addTask(self, t: Any) -> None:
        """Run a task, too."""
        self.tasks.append(t)


class DiagnosticTaskVector:
    """Tasks by name.

    Attributes:
        tasks: the tasks. lock: held while they are looked at.
    """

    class DiagnosticTaskInternal:
        """A task in the vector: a name and a function."""

        def __init__(self, name: str, fn: Callable[[Any], Any]) -> None:
            self.name = name
            self.fn = fn

        def run(self, stat: Any) -> Any:
            """Fill a status and return it."""
            stat.name = self.name
            return self.fn(stat)

    def __init__(self) -> None:
        self.tasks: list[Any] = []
        self.lock = threading.Lock()

    def addedTaskCallback(self, task: Any) -> None:
        """Called with each new task."""

    def add(self, *args: Any) -> None:
        """Add a task: a DiagnosticTask, or a name and a function that fills a status and returns it."""
        if len(args) == 1:
            name, function = args[0].getName(), args[0].run
        elif len(args) == 2:
            name, function = args
        else:
            raise TypeError(f"add() takes a task, or a name and a function: {len(args)} arguments were given")
        task = self.DiagnosticTaskInternal(name, function)
        with self.lock:
            self.tasks.append(task)
            self.addedTaskCallback(task)

    def removeByName(self, name: str) -> bool:
        """Remove the first task of a name; return whether there was one."""
        with self.lock:
            for task in self.tasks:
                if task.name == name:
                    self.tasks.remove(task)
                    return True
        return False


class Updater(DiagnosticTaskVector):
    """Runs the tasks when the program calls `update`, and publishes what they say on /diagnostics.

    Attributes:
        period: seconds between two runs: the parameter ``~diagnostic_period``, or 1. verbose: whether problems are
            logged. hwid: what `setHardwareID` set. last_time: of the last run.
    """

    def __init__(self) -> None:
        super().__init__()
        self.publisher = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=10)
        self.last_time = self.last_time_period_checked = rospy.Time.now()
        self.period: float = 1
        self.verbose = False
        self.hwid = ""
        self.warn_nohwid_done = False
        self.period = rospy.get_param("~diagnostic_period", self.period)

    def update(self) -> None:
        """Run all tasks, if the period since the last time is over."""
        self._check_period()
        if rospy.Time.now() >= self.last_time + rospy.Duration.from_sec(float(self.period)):
            self.force_update()

    def _check_period(self) -> None:
        now = rospy.Time.now()
        if now >= self.last_time_period_checked + rospy.Duration.from_sec(float(self.period)):
            self.period = rospy.get_param("~diagnostic_period", self.period)
            self.last_time_period_checked = now

    def force_update(self) -> None:
        """Run all tasks now."""
        self.last_time = rospy.Time.now()
        found = []
        with self.lock:
            for task in self.tasks:
                status = DiagnosticStatusWrapper()
                status.summary(*UNSET)
                status.name = task.name
                status.hardware_id = self.hwid
                task.run(status)
                found.append(status)
                if status.level and self.verbose:
                    rospy.logwarn(
                        "Non-zero diagnostic status. Name: '%s', status %i: '%s'",
                        status.name,
                        status.level,
                        status.message,
                    )
        self.publish(found)

    def broadcast(self, lvl: int, msg: str) -> None:
        """Publish the same level and message for all tasks."""
        self.publish([DiagnosticStatusWrapper(level=lvl, name=task.name, message=msg) for task in self.tasks])

    def setHardwareID(self, hwid: str) -> None:
        """Tell this piece of hardware from others."""
        self.hwid = hwid

    def publish(self, msg: Any) -> None:
        """Publish one status, or a list of them; the node's name is put before theirs."""
        found = msg if isinstance(msg, list) else [msg]
        for status in found:
            status.name = f"{rospy.get_name()[1:]}: {status.name}"
        array = DiagnosticArray(status=found)
        array.header.stamp = rospy.Time.now()
        self.publisher.publish(array)

    def addedTaskCallback(self, task: Any) -> None:
        """Announce a new task."""
        self.publish(DiagnosticStatusWrapper(level=OK, name=task.name, message="Node starting up"))
