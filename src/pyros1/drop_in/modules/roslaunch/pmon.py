"""Processes of launches, as programs see them."""

from __future__ import annotations

import weakref
from typing import Any

from pyros1.drop_in.missing import missing
from pyros1.ground.errors import LaunchError
from roslaunch.core import RLException, printerrlog, printlog, printlog_bold

__all__ = [
    "DeadProcess",
    "FatalProcessLaunch",
    "Process",
    "ProcessListener",
    "ProcessMonitor",
    "RLException",
    "pmon_shutdown",
    "printerrlog",
    "printlog",
    "printlog_bold",
    "shutdown_process_monitor",
    "start_process_monitor",
]


_shutting_down = False  # programs set it to False to launch again after an end, which is always possible here


class FatalProcessLaunch(RLException):
    """A process cannot be started, and the launch must end."""


class ProcessListener:
    """Is told when processes end."""

    def process_died(self, process_name: str, exit_code: int | None) -> None:
        """A process has ended.

        Args:
            process_name: its name, as "talker-1".
            exit_code: negative for a signal.
        """


class Process:
    """A process of a launch.

    Attributes:
        package, args, respawn, required: of the node. name: as "talker-1".
    """

    def __init__(
        self,
        package: str,
        name: str,
        args: Any,
        env: Any,
        respawn: bool = False,
        respawn_delay: float = 0.0,
        required: bool = False,
        handle: Any = None,
    ) -> None:
        self.package = package
        self.name = name
        self.args = args
        self.env = env
        self.respawn = respawn
        self.respawn_delay = respawn_delay
        self.required = required
        self._handle = handle

    def __str__(self) -> str:
        return f"Process<{self.name}>"

    @property
    def exit_code(self) -> int | None:
        """Exit code: None while it runs, negative for a signal."""
        return self._handle.exit_code if self._handle else None

    @property
    def pid(self) -> int:
        """Its number in the system; -1 if it was not started."""
        return self._handle.pid if self._handle else -1

    def is_alive(self) -> bool:
        """Return whether it runs."""
        return bool(self._handle and self._handle.is_alive())

    def should_respawn(self) -> float | bool:
        """Return the seconds after which it starts again, or False."""
        return self.respawn_delay if self.respawn else False

    def get_info(self) -> dict[str, Any]:
        """Return what is known, by name."""
        info = {"name": self.name, "alive": self.is_alive(), "respawn": self.respawn, "required": self.required}
        if self.exit_code is not None:
            info["exit_code"] = self.exit_code
        return {**info, "pid": self.pid}

    def get_exit_description(self) -> str:
        """Return how it ended."""
        code = self.exit_code
        if code is None:
            return "process has died"
        return f"process has died [pid {self.pid}, exit code {code}]" if code else "process has finished cleanly"

    def start(self) -> None:
        """Not possible: a launch starts its processes itself."""
        raise RLException("pyros1 starts processes itself: use ROSLaunchRunner.launch_node or ROSLaunch.launch")

    def stop(self, errors: list[str] | None = None) -> None:
        """End it, and wait until it has ended; a text is added to ``errors`` if it does not."""
        if self._handle is not None:
            self._handle.stop(errors)


class DeadProcess(Process):
    """A process that has ended."""

    def __init__(self, p: Process) -> None:
        super().__init__(p.package, p.name, p.args, p.env, p.respawn, p.respawn_delay, p.required)
        self._code = p.exit_code

    @property
    def exit_code(self) -> int | None:
        """Exit code; negative for a signal."""
        return self._code


class ProcessMonitor:
    """The processes of the launches that were started with it.

    A launch of pyros1 supervises its processes itself: this shows them, and can end them.
    """

    def __init__(self, name: str = "ProcessMonitor") -> None:
        self.name = name
        self.listeners: list[Any] = []
        self.is_shutdown = False
        self.runs: list[Any] = []
        self.processes: dict[str, Process] = {}
        _monitors.add(self)

    def add_process_listener(self, l: Any) -> None:  # noqa: E741
        """Tell an object with ``process_died`` of each process that ends."""
        self.listeners.append(l)

    def process_died(self, process_name: str, exit_code: int | None) -> None:
        """Pass on the end of a process."""
        for listener in list(self.listeners):
            listener.process_died(process_name, exit_code)

    def has_process(self, name: str) -> bool:
        """Return whether a process of that name runs."""
        return name in self.get_active_names()

    def get_process(self, name: str) -> Process | None:
        """Return a running process; None if there is none of that name."""
        handles = {handle.name: handle for run in self.runs for handle in run.processes()}
        if name not in handles:
            return None
        return self.processes.get(name) or Process("", name, [], {}, handle=handles[name])

    def kill_process(self, name: str) -> bool:
        """End a process; return whether there was one."""
        process = self.get_process(name)
        if process is not None:
            process.stop()
        return process is not None

    def get_active_names(self) -> list[str]:
        """Return the names of all running processes."""
        return [handle.name for run in self.runs for handle in run.processes()]

    def get_process_names_with_spawn_count(self) -> list[list[tuple[str, int]]]:
        """Return two lists of names and numbers of starts: of what runs, and an empty one: of what has ended."""
        return [[(name, 1) for name in self.get_active_names()], []]

    def has_main_thread_jobs(self) -> bool:
        """Return False: each launch has its thread."""
        return False

    def do_main_thread_jobs(self) -> None:
        """Do nothing: there are none."""

    def registrations_complete(self) -> None:
        """Do nothing: a launch ends by itself when no process is left."""

    def is_alive(self) -> bool:
        """Return whether it watches."""
        return not self.is_shutdown

    def join(self, timeout: float | None = None) -> None:
        """Do nothing: `shutdown` waits."""

    def mainthread_spin_once(self) -> None:
        """Do nothing: each launch has its thread."""

    def mainthread_spin(self) -> None:
        """Wait until all launches have ended."""
        for run in list(self.runs):
            while not run.wait(0.2):
                pass

    def shutdown(self) -> None:
        """End all processes, and wait until they have ended."""
        self.is_shutdown = True
        for run in self.runs:
            run.stop()
        _monitors.discard(self)

    def register(self, p: Any) -> None:
        """Not possible: a launch starts its processes itself."""
        raise LaunchError("pyros1 starts processes itself: use ROSLaunchRunner.launch_node or ROSLaunch.launch")

    register_core_proc = register


_monitors: weakref.WeakSet[ProcessMonitor] = weakref.WeakSet()


def start_process_monitor() -> ProcessMonitor:
    """Return a new monitor."""
    return ProcessMonitor()


def shutdown_process_monitor(process_monitor: Any) -> bool:
    """End a monitor's processes; return whether all have ended."""
    if process_monitor is None or process_monitor.is_shutdown:
        return True
    process_monitor.shutdown()
    return True


def pmon_shutdown() -> None:
    """End the processes of all monitors."""
    for monitor in list(_monitors):
        monitor.shutdown()


__getattr__ = missing(
    "roslaunch.pmon",
    rl_signal="each launch handles its end itself",
    _init_signal_handlers="each launch handles its end itself",
)
