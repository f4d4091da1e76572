"""Tasks, lists of tasks, and the updater that publishes their results."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import rospy

from diagnostic_updater._diagnostic_status_wrapper import OK, DiagnosticStatusWrapper
from pyros1.diagnostics import Combined
from pyros1.diagnostics.updater import UNSET_SUMMARY
from pyros1.drop_in.module_attributes import module_getattr
from pyros1.msgs.diagnostic_msgs.msg import DiagnosticArray

__getattr__ = module_getattr("diagnostic_updater._diagnostic_updater")

_PERIOD_CHECK_INTERVAL = 0.1
"""Seconds between reads of the parameter ``~diagnostic_period``."""


class DiagnosticTask:
    """A task that fills in a status; implemented by subclasses.

    Args:
        name: name of the status that the task fills in.
    """

    def __init__(self, name: str) -> None:
        self.name = name

    def getName(self) -> str:
        """Return the name."""
        return self.name

    def run(self, stat: Any) -> Any:
        """Fill in a `DiagnosticStatusWrapper` and return it."""
        return stat


class FunctionDiagnosticTask(DiagnosticTask):
    """A task that calls a function.

    Args:
        name: name of the status that the task fills in.
        fn: called with a `DiagnosticStatusWrapper`, which it fills in and returns.
    """

    def __init__(self, name: str, fn: Callable[[Any], Any]) -> None:
        super().__init__(name)
        self.fn = fn

    def run(self, stat: Any) -> Any:
        """Call the function."""
        return self.fn(stat)


class CompositeDiagnosticTask(DiagnosticTask):
    """Several tasks that fill in one status: their values are added one after the other, their summaries merged.

    Args:
        name: name of the status that the tasks fill in.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.tasks: list[Any] = []

    def addTask(self, t: Any) -> None:
        """Add a `DiagnosticTask`."""
        self.tasks.append(t)

    def run(self, stat: Any) -> Any:
        """Run all tasks."""
        Combined([task.run for task in self.tasks]).run(stat)
        return stat


class DiagnosticTaskVector:
    """A list of tasks."""

    class DiagnosticTaskInternal:
        """A task in the list: a name and a function."""

        def __init__(self, name: str, fn: Callable[[Any], Any]) -> None:
            self.name = name
            self.fn = fn

        def run(self, stat: Any) -> Any:
            """Fill in a status, which has the name of the task, and return it."""
            stat.name = self.name
            return self.fn(stat)

    def __init__(self) -> None:
        self.tasks: list[Any] = []
        self.lock = threading.RLock()

    def addedTaskCallback(self, task: Any) -> None:
        """Handle a new `DiagnosticTaskInternal`; may be overridden by subclasses."""

    def add(self, *args: Any) -> None:
        """Add a `DiagnosticTask`, or a name and a function for a `FunctionDiagnosticTask`."""
        if len(args) == 1:
            task = self.DiagnosticTaskInternal(args[0].getName(), args[0].run)
        else:
            name, function = args
            task = self.DiagnosticTaskInternal(name, function)
        with self.lock:
            self.tasks.append(task)
            self.addedTaskCallback(task)

    def removeByName(self, name: str) -> bool:
        """Remove the first task with the given name; return whether there was one."""
        with self.lock:
            match = next((task for task in self.tasks if task.name == name), None)
            if match is not None:
                self.tasks.remove(match)
        return match is not None


class Updater(DiagnosticTaskVector):
    """Publishes the results of its tasks on /diagnostics, when the program calls `update`.

    The parameter ``~diagnostic_period`` is the period in seconds (default 1).

    Attributes:
        verbose: whether to log each status that is not OK.
        hwid: the identifier of the hardware.
        period: the period in seconds.
        last_time: rospy.Time of the last publication.
        publisher: the rospy.Publisher.
    """

    def __init__(self) -> None:
        super().__init__()
        self.publisher = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=10)
        self.last_time = self.last_time_period_checked = rospy.Time.now()
        self.period: Any = 1
        self.verbose = False
        self.hwid = ""
        self.warn_nohwid_done = False

    def addedTaskCallback(self, task: Any) -> None:
        """Announce a new task."""
        self.publish(DiagnosticStatusWrapper(name=task.name, level=OK, message="Node starting up"))

    def setHardwareID(self, hwid: str) -> None:
        """Set the identifier of this piece of hardware; "none" if there is none."""
        self.hwid = hwid

    def update(self) -> None:
        """Run the tasks and publish the results if the period has passed; must be called frequently."""
        self._check_diagnostic_period()
        if not self.last_time <= rospy.Time.now() < self.last_time + rospy.Duration(self.period):  # time may jump back
            self.force_update()

    def force_update(self) -> None:
        """Run the tasks and publish the results now. Exceptions raised by tasks are not caught."""
        self.last_time = rospy.Time.now()
        with self.lock:
            tasks = list(self.tasks)
        statuses = []
        for task in tasks:
            status = DiagnosticStatusWrapper(name=task.name, hardware_id=self.hwid)
            status.summary(*UNSET_SUMMARY)
            task.run(status)
            statuses.append(status)
        problems = [status for status in statuses if status.level != OK]
        if self.verbose:
            for status in problems:
                rospy.logwarn(
                    "Non-zero diagnostic status. Name: '%s', status %i: '%s'",
                    *(status.name, status.level, status.message),
                )
        if not self.hwid and not problems and not self.warn_nohwid_done:
            self.warn_nohwid_done = True
            rospy.logwarn(
                "diagnostic_updater: No HW_ID was set. This is probably a bug. Please report it. For devices that do "
                "not have a HW_ID, set this value to 'none'. This warning only occurs once all diagnostics are OK so "
                "it is okay to wait until the device is open before calling setHardwareID."
            )
        self.publish(statuses)

    def broadcast(self, lvl: int, msg: str) -> None:
        """Publish the same level and message for all tasks, for example before the node shuts down."""
        with self.lock:
            names = [task.name for task in self.tasks]
        self.publish([DiagnosticStatusWrapper(name=name, level=lvl, message=msg) for name in names])

    def publish(self, msg: Any) -> None:
        """Publish a DiagnosticStatus, or a list of them; the node's name is prepended to their names."""
        statuses = msg if isinstance(msg, list) else [msg]
        for status in statuses:
            status.name = f"{rospy.get_name()[1:]}: {status.name}"
        array = DiagnosticArray(status=statuses)
        array.header.stamp = rospy.Time.now()
        self.publisher.publish(array)

    def _check_diagnostic_period(self) -> None:
        """Apply a change of the parameter ~diagnostic_period."""
        now = rospy.Time.now()
        if not 0 <= (now - self.last_time_period_checked).to_sec() < _PERIOD_CHECK_INTERVAL:
            self.last_time_period_checked = now
            self.period = rospy.get_param_cached("~diagnostic_period", 1)
