"""Processes of launches, as programs see them."""

from __future__ import annotations

import itertools
import logging
import threading
import time
import traceback
import weakref
from dataclasses import asdict
from typing import Any

from pyros1.drop_in.missing import missing
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


logger = logging.getLogger("roslaunch.pmon")
_PERIOD_S = 0.1
_shutting_down = False  # programs set it to False to launch again after a shutdown, which is always possible here


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
    """A process of a launch; a program may derive its own from it, for `ProcessMonitor.register`.

    Attributes:
        package, name, args, env, respawn, respawn_delay, required: as given. spawn_count: how often it was started.
        exit_code: None while it runs, negative for a signal. time_of_death: when it was first seen not to run, in
        seconds, or None. pid: its number in the system; -1 if it was not started.
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
        self.spawn_count = 0 if handle is None else 1
        self.time_of_death: float | None = None
        self.pid = -1 if handle is None else handle.pid
        self._handle = handle
        self._exit_code: int | None = None

    def __str__(self) -> str:
        return f"Process<{self.name}>"

    @property
    def exit_code(self) -> int | None:
        """Exit code: None while it runs, negative for a signal."""
        code: int | None = self._exit_code if self._handle is None else self._handle.exit_code
        return code

    @exit_code.setter
    def exit_code(self, code: int | None) -> None:
        self._exit_code = code

    def is_alive(self) -> bool:
        """Return whether it runs; here, what pyros1 did not start does not."""
        if self._handle is not None and self._handle.is_alive():
            self.pid = self._handle.pid  # a new one after a respawn
            return True
        if self.time_of_death is None:
            self.time_of_death = time.time()
        return False

    def should_respawn(self) -> float | bool:
        """Return the seconds until it starts again, negative if it should have; False if it does not."""
        return self.respawn and (self.time_of_death or time.time()) + self.respawn_delay - time.time()

    def get_info(self) -> dict[str, Any]:
        """Return what is known, by name."""
        info = {name: getattr(self, name) for name in ("spawn_count", "args", "env", "package", "name")}
        info["alive"] = self.is_alive()
        info |= {name: getattr(self, name) for name in ("respawn", "respawn_delay", "required")}
        if self.exit_code is not None:
            info["exit_code"] = self.exit_code
        return info if self._handle is None else {**info, "pid": self.pid}

    def get_exit_description(self) -> str:
        """Return how it ended."""
        code = self.exit_code
        if code is None:
            return "process has died"
        pid = "" if self._handle is None else f"pid {self.pid}, "
        return f"process has died [{pid}exit code {code}]" if code else "process has finished cleanly"

    def start(self) -> Any:
        """Count a start; classes of programs do it. Raises RLException for what pyros1 starts itself."""
        if self._handle is not None:
            raise RLException("pyros1 starts processes itself: use ROSLaunchRunner.launch_node or ROSLaunch.launch")
        self.spawn_count += 1
        self.time_of_death = None

    def stop(self, errors: list[str] | None = None) -> None:
        """End it, and wait until it has ended; a text is added to ``errors`` if it does not."""
        if self._handle is not None:
            self._handle.stop(errors)


def _option(name: str) -> Any:
    """Return the property of an option of a launched process, which applies to the launch immediately."""
    return property(
        lambda self: getattr(self._handle.spec.exit_policy, name),
        lambda self, value: setattr(self._handle.spec.exit_policy, name, value),
    )


class _Launched(Process):
    """A process that a launch supervises."""

    respawn = _option("respawn")
    respawn_delay = _option("respawn_delay")
    required = _option("required")

    def __init__(self, handle: Any) -> None:
        self._handle = handle
        spec = handle.spec
        super().__init__(spec.package, handle.name, spec.words, spec.env, **asdict(spec.exit_policy), handle=handle)

    def is_alive(self) -> bool:
        """Return whether it is running."""
        self.spawn_count = self._handle.spawn_count
        return super().is_alive()

    def stop(self, errors: list[str] | None = None) -> None:
        """End it, and wait until it has ended; it starts again if it respawns."""
        self._handle.end(errors)


class DeadProcess(Process):
    """A process that has ended."""

    def __init__(self, p: Process) -> None:
        super().__init__(p.package, p.name, p.args, p.env, p.respawn, p.respawn_delay)
        self.exit_code = p.exit_code
        self.spawn_count = p.spawn_count
        self.pid = p.pid
        self.time_of_death = p.time_of_death
        self._info = {**p.get_info(), "alive": False}

    def get_info(self) -> dict[str, Any]:
        """Return what is known, by name."""
        return self._info

    def is_alive(self) -> bool:
        """Return False."""
        return False

    def start(self) -> None:
        """Raise an exception: it has ended."""
        raise Exception("cannot call start on a dead process!")


class ProcessMonitor(threading.Thread):
    """The processes of the launches that were started with it, and those that a program registers.

    A launch of pyros1 supervises its processes itself: this shows them, and can end them. As a thread, it watches the
    registered ones: it starts them again, tells listeners of their end, and ends the others with a required one.
    """

    def __init__(self, name: str = "ProcessMonitor") -> None:
        super().__init__(name=name, daemon=True)
        self.listeners: list[Any] = []
        self._shut_down = False
        self.runs: list[Any] = []
        self._launched: dict[str, _Launched] = {}
        self._registered: list[Process] = []
        self._dead: list[DeadProcess] = []
        self.done = False
        self._complete = False
        self._waiting: set[Process] = set()
        self._wake = threading.Event()
        self._end = threading.Event()
        _monitors.add(self)

    @property
    def is_shutdown(self) -> bool:
        """Whether it has been shut down, or all that was launched has ended."""
        return self._shut_down or (bool(self.runs) and not self._registered and all(run.is_over() for run in self.runs))

    @is_shutdown.setter
    def is_shutdown(self, value: bool) -> None:
        self._shut_down = value

    @property
    def procs(self) -> list[Process]:
        """The processes that run: those that a program registered, and those of launches."""
        return self._registered + [self.launched(handle) for run in self.runs for handle in run.processes()]

    @property
    def dead_list(self) -> list[DeadProcess]:
        """The processes that have ended for good."""
        handles = [handle for run in self.runs for handle in run.dead_processes()]
        return self._dead + [DeadProcess(self.launched(handle)) for handle in handles]

    def launched(self, handle: Any) -> Process:
        """Return the process of a launch's handle, the same one each time."""
        process = self._launched.setdefault(handle.name, _Launched(handle))
        process.is_alive()  # updates its pid and number of starts
        return process

    def add_process_listener(self, l: Any) -> None:  # noqa: E741
        """Tell an object with ``process_died`` of each process that ends."""
        self.listeners.append(l)

    def process_died(self, process_name: str, exit_code: int | None) -> None:
        """Pass on the end of a process; an error of a listener is printed."""
        for listener in list(self.listeners):
            try:
                listener.process_died(process_name, exit_code)
            except Exception:  # noqa: BLE001 - the program's code: the other listeners are called as well
                traceback.print_exc()

    # Processes of programs --------------------------------------------------------------------------------------------

    def register(self, p: Process) -> None:
        """Watch a process, which the program starts.

        Raises:
            RLException: there is one of that name, or the monitor has ended.
        """
        if self.has_process(p.name):
            raise RLException(f"cannot add process with duplicate name '{p.name}'")
        if self.done:
            raise RLException(f"cannot add process [{p.name}] after process monitor has been shut down")
        self._registered.append(p)
        self._wake.set()

    def register_core_proc(self, p: Process) -> None:
        """Watch a process that others need; see `register`."""
        self.register(p)

    def registrations_complete(self) -> None:
        """End when all registered processes have ended. (A launch always ends by itself.)"""
        self._complete = True
        self._wake.set()

    def unregister(self, p: Process) -> None:
        """Watch a process no longer; raises ValueError if it is not watched."""
        self._registered.remove(p)

    def run(self) -> None:
        """Watch the registered processes until the end."""
        self._wake.wait()  # most programs register no processes
        while not self._end.wait(_PERIOD_S):
            for process in list(self._registered):
                if not process.is_alive() and process in self._registered:
                    self._ended(process)
            if self._complete and self._dead and not self._registered:
                printlog("all processes on machine have died, roslaunch will exit")
                self._end.set()
            if self._end.is_set():
                break
        self._shut_down = True
        for process in reversed(self._registered):
            printlog(f"[{process.name}] killing on exit")
            _stop(process)
        self.done = True

    def _ended(self, process: Process) -> None:
        wait = process.should_respawn()
        if process not in self._waiting:
            text = f"[{process.name}] {process.get_exit_description()}"
            (printerrlog if process.exit_code else printlog_bold)(text)
            self.process_died(process.name, process.exit_code)
        if process.required:
            line = "=" * 80
            printerrlog(
                f"{line}REQUIRED process [{process.name}] has died!\n{process.get_exit_description()}\n"
                f"Initiating shutdown!\n{line}"
            )
            self._end.set()
        elif wait is False:
            _stop(process)
            self.unregister(process)
            self._dead.append(DeadProcess(process))
        elif wait > 0:
            self._waiting.add(process)
        else:
            self._waiting.discard(process)
            printlog(f"[{process.name}] restarting process")
            _stop(process)
            process.start()

    # All processes ----------------------------------------------------------------------------------------------------

    def has_process(self, name: str) -> bool:
        """Return whether a process of that name runs."""
        return name in self.get_active_names()

    def get_process(self, name: str) -> Process | None:
        """Return a running process; None if there is none of that name."""
        return next((process for process in self.procs if process.name == name), None)

    def kill_process(self, name: str) -> bool:
        """End a process; return whether there was one. Raises RLException if it is no name."""
        if not isinstance(name, str):
            raise RLException(f"kill_process takes in a process name but was given: {name}")
        printlog(f"[{name}] kill requested")
        process = self.get_process(name)
        if process is not None:
            _stop(process)
        return process is not None

    def get_active_names(self) -> list[str]:
        """Return the names of all running processes."""
        return [each.name for each in self.procs]

    def get_process_names_with_spawn_count(self) -> list[list[tuple[str, int]]]:
        """Return two lists of names and numbers of starts: of what runs, and of what has ended."""
        return [[(each.name, each.spawn_count) for each in processes] for processes in (self.procs, self.dead_list)]

    # Main thread ------------------------------------------------------------------------------------------------------

    def has_main_thread_jobs(self) -> int:
        """Return 0: nothing is left to the main thread."""
        return 0

    def do_main_thread_jobs(self) -> None:
        """Do nothing: there are none."""

    def mainthread_spin_once(self) -> bool:
        """Return whether it has not ended yet."""
        return not self.done

    def mainthread_spin(self) -> None:
        """Wait until all launches have ended, and the registered processes if the monitor was started."""
        for run in list(self.runs):
            while not run.wait(0.2):
                pass
        while self.is_alive() and self._wake.is_set():
            self.join(0.2)

    def shutdown(self) -> None:
        """End all processes, and wait until they have ended."""
        self._shut_down = True
        for run in self.runs:
            run.stop()
        self._end.set()
        self._wake.set()
        if self.is_alive() and threading.current_thread() is not self:
            self.join()
        _monitors.discard(self)


def _stop(process: Process) -> None:
    try:
        process.stop([])
    except Exception:  # noqa: BLE001 - the program's code: the other processes are ended as well
        traceback.print_exc()


_monitors: weakref.WeakSet[ProcessMonitor] = weakref.WeakSet()
_numbers = itertools.count(1)


def start_process_monitor() -> ProcessMonitor:
    """Return a new monitor, which watches."""
    monitor = ProcessMonitor(f"ProcessMonitor-{next(_numbers)}")
    monitor.start()
    return monitor


def shutdown_process_monitor(process_monitor: Any) -> bool:
    """End a monitor and its processes; return False if there was nothing to end, or it has not ended."""
    if process_monitor is None or process_monitor._shut_down:
        return False
    process_monitor.shutdown()
    return not process_monitor.is_alive()


def pmon_shutdown() -> None:
    """End the processes of all monitors."""
    for monitor in list(_monitors):
        monitor.shutdown()


__getattr__ = missing(
    "roslaunch.pmon",
    rl_signal="each launch handles its end itself",
    _init_signal_handlers="each launch handles its end itself",
)
