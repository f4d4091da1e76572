"""Gives programs access to the processes of launches, which pyros1 supervises itself."""

from __future__ import annotations

import itertools
import logging
import time
import traceback
import weakref
from typing import Any

from pyros1.drop_in.module_attributes import class_getattr, module_getattr
from roslaunch.core import RLException

__all__ = [
    "Process",
    "ProcessListener",
    "ProcessMonitor",
    "RLException",
    "pmon_shutdown",
    "shutdown_process_monitor",
    "start_process_monitor",
]

_POLL_S = 0.2
_REASON = "pyros1 starts processes itself: use ROSLaunchRunner.launch_node or ROSLaunch.launch"

logger = logging.getLogger("roslaunch.pmon")
_shutting_down = False  # programs set it to False to launch again after a shutdown; pyros1 always allows that


def _init_signal_handlers() -> None:
    """Do nothing: a launch sets no signal handlers. Programs replace this function, or call it."""


class ProcessListener:
    """A listener that is notified when processes exit."""

    def process_died(self, process_name: str, exit_code: int | None) -> None:
        """Handle the end of a process.

        Args:
            process_name: name of the process, such as "talker-1".
            exit_code: the exit code; negative for a signal.
        """


def _policy_property(name: str) -> Any:
    """Return a property for one of a process's options; changes take effect immediately."""
    return property(
        lambda self: getattr(self._handle.spec.exit_policy, name),
        lambda self, value: setattr(self._handle.spec.exit_policy, name, value),
    )


class Process:
    """A process of a launch.

    Args:
        handle: the pyros1.launch.scripting.ProcessHandle.

    Attributes:
        package, name, args, env: how it was started.
        respawn, respawn_delay, required: what happens when it exits; they may be changed.
    """

    respawn = _policy_property("respawn")
    respawn_delay = _policy_property("respawn_delay")
    required = _policy_property("required")

    def __init__(self, handle: Any) -> None:
        spec = handle.spec
        self._handle = handle
        self.package, self.name, self.args, self.env = spec.package, handle.name, spec.words, spec.env

    __getattr__ = class_getattr("Process", _REASON, frozenset(["start", "should_respawn", "time_of_death"]))

    def __str__(self) -> str:
        return f"Process<{self.name}>"

    @property
    def spawn_count(self) -> int:
        """The number of times that the process was started."""
        count: int = self._handle.spawn_count
        return count

    @property
    def pid(self) -> int:
        """The process id, which changes with each respawn."""
        pid: int = self._handle.pid
        return pid

    @property
    def exit_code(self) -> int | None:
        """The exit code: None while the process is running, negative for a signal."""
        code: int | None = self._handle.exit_code
        return code

    def is_alive(self) -> bool:
        """Return whether the process is running."""
        alive: bool = self._handle.is_alive()
        return alive

    def get_info(self) -> dict[str, Any]:
        """Return the process's attributes by name."""
        names = ("spawn_count", "args", "env", "package", "name", "respawn", "respawn_delay", "required", "pid")
        info = {**{name: getattr(self, name) for name in names}, "alive": self.is_alive()}
        return info if self.exit_code is None else {**info, "exit_code": self.exit_code}

    def get_exit_description(self) -> str:
        """Return a description of how the process exited."""
        code = self.exit_code
        if code == 0:
            return "process has finished cleanly"
        return "process has died" + (f" [pid {self.pid}, exit code {code}]" if code else "")

    def stop(self, errors: list[str] | None = None) -> None:
        """End the process, and wait until it has exited. A process with ``respawn`` is then started again.

        Args:
            errors: list to which a message is added if the process does not exit.
        """
        self._handle.end(errors)


class ProcessMonitor:
    """The processes of all launches that were started with this monitor.

    Args:
        name: name of the monitor.

    Attributes:
        name: name of the monitor.
        runs: the launches.
    """

    __getattr__ = class_getattr("ProcessMonitor", _REASON, frozenset(["register", "register_core_proc", "unregister"]))

    def __init__(self, name: str = "ProcessMonitor") -> None:
        self.name = name
        self.runs: list[Any] = []
        self._listeners: list[Any] = []
        self._launched: dict[str, Process] = {}
        self._started = self._shut_down = False
        _monitors.add(self)

    @property
    def is_shutdown(self) -> bool:
        """Whether the monitor was shut down, or all its launches have ended."""
        return self._shut_down or (bool(self.runs) and all(run.is_over() for run in self.runs))

    @property
    def done(self) -> bool:
        """Whether all processes have ended and will not respawn; see `is_shutdown`."""
        return self.is_shutdown

    def start(self) -> None:
        """Start the monitor. It does nothing itself: each launch supervises its own processes."""
        self._started = True

    def is_alive(self) -> bool:
        """Return whether the monitor was started and has not ended."""
        return self._started and not self.is_shutdown

    def join(self, timeout: float | None = None) -> None:
        """Wait until the monitor has ended, for ``timeout`` seconds at most."""
        end = None if timeout is None else time.monotonic() + timeout
        while self.is_alive() and (end is None or time.monotonic() < end):
            time.sleep(_POLL_S)

    # Processes --------------------------------------------------------------------------------------------------------

    @property
    def procs(self) -> list[Process]:
        """The running processes."""
        return [self.process_for(handle) for run in self.runs for handle in run.processes()]

    @property
    def dead_list(self) -> list[Process]:
        """The processes that have exited and are not respawned."""
        return [self.process_for(handle) for run in self.runs for handle in run.dead_processes()]

    def process_for(self, handle: Any) -> Process:
        """Return the Process object for a launch's handle; repeated calls return the same object."""
        return self._launched.setdefault(handle.name, Process(handle))

    def has_process(self, name: str) -> bool:
        """Return whether a process with that name is running."""
        return name in self.get_active_names()

    def get_process(self, name: str) -> Process | None:
        """Return the running process with the given name; None if there is none."""
        return next((process for process in self.procs if process.name == name), None)

    def get_active_names(self) -> list[str]:
        """Return the names of all running processes."""
        return [process.name for process in self.procs]

    def get_process_names_with_spawn_count(self) -> list[list[tuple[str, int]]]:
        """Return (running, dead): two lists of (name, number of starts) of processes."""
        return [
            [(process.name, process.spawn_count) for process in processes] for processes in (self.procs, self.dead_list)
        ]

    def kill_process(self, name: str) -> bool:
        """Stop the named process; return whether there was one. Raise RLException if the name is not a string."""
        if not isinstance(name, str):
            raise RLException(f"kill_process takes in a process name but was given: {name}")
        process = self.get_process(name)
        if process is not None:
            process.stop([])
        return process is not None

    # Listeners and shutdown -------------------------------------------------------------------------------------------

    def add_process_listener(self, l: Any) -> None:  # noqa: E741
        """Call an object's ``process_died`` for each process that exits."""
        self._listeners.append(l)

    def process_died(self, process_name: str, exit_code: int | None) -> None:
        """Notify the listeners that a process has exited; exceptions that they raise are printed."""
        for listener in list(self._listeners):
            try:
                listener.process_died(process_name, exit_code)
            except Exception:  # noqa: BLE001 - the program's code: the other listeners are called as well
                traceback.print_exc()

    def registrations_complete(self) -> None:
        """Do nothing: a launch ends by itself."""

    def mainthread_spin_once(self) -> bool:
        """Return whether the monitor is still running."""
        return not self.is_shutdown

    def mainthread_spin(self) -> None:
        """Wait until all launches have ended."""
        for run in list(self.runs):
            while not run.wait(_POLL_S):
                pass

    def shutdown(self) -> None:
        """Stop all processes, and wait until they have exited."""
        self._shut_down = True
        for run in self.runs:
            run.stop()
        _monitors.discard(self)


_monitors: weakref.WeakSet[ProcessMonitor] = weakref.WeakSet()
_monitor_numbers = itertools.count(1)


def start_process_monitor() -> ProcessMonitor:
    """Return a new monitor."""
    monitor = ProcessMonitor(f"ProcessMonitor-{next(_monitor_numbers)}")
    monitor.start()
    return monitor


def shutdown_process_monitor(process_monitor: Any) -> bool:
    """Shut down a monitor and its processes; return False if there is none, or it was already shut down."""
    if process_monitor is None or process_monitor.is_shutdown:
        return False
    process_monitor.shutdown()
    return True


def pmon_shutdown() -> None:
    """Stop the processes of all monitors."""
    for monitor in list(_monitors):
        monitor.shutdown()


__getattr__ = module_getattr(
    "roslaunch.pmon",
    DeadProcess="see ProcessMonitor.dead_list",
    FatalProcessLaunch=_REASON,
    rl_signal="a launch sets no signal handlers",
)
