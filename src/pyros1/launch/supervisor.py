"""Keeps a set of processes as their specs ask for, and ends them all in good order (X87-X90).

One queue carries what happens (a process ended, a signal came, a master was told to shut down); the thread in `run`
sleeps on it until then, or until the next respawn is due. Nothing polls.
"""

from __future__ import annotations

import queue
import signal
import time
from collections.abc import Callable
from typing import Literal

from pyros1.launch.console import Console
from pyros1.launch.process import Process, ProcessSpec

_KILL_WAIT = 2.0
Event = tuple[Literal["exit", "stop", "hurry"], "Process | str | None"]


class Supervisor:
    """Starts and watches processes.

    Args:
        console: where lines for the user go.
        sigint_timeout: seconds between SIGINT and SIGTERM.
        sigterm_timeout: seconds between SIGTERM and SIGKILL.
        keep_running: go on when no process is left (the core does).
    """

    def __init__(
        self,
        console: Console,
        *,
        sigint_timeout: float = 15.0,
        sigterm_timeout: float = 2.0,
        keep_running: bool = False,
    ) -> None:
        self._console = console
        self._sigint_timeout = sigint_timeout
        self._sigterm_timeout = sigterm_timeout
        self._keep_running = keep_running
        # A SimpleQueue may be fed from a signal handler, whatever the main thread was doing.
        self._events: queue.SimpleQueue[Event] = queue.SimpleQueue()
        self._respawns: dict[str, float] = {}
        self._processes: dict[str, Process] = {}
        self._dead: dict[str, Process] = {}
        self._stopping = False

    @property
    def active(self) -> list[Process]:
        """The processes that run or will be started again, in the order of their start."""
        return list(self._processes.values())

    @property
    def dead(self) -> list[Process]:
        """The processes that have ended for good."""
        return list(self._dead.values())

    def start(self, spec: ProcessSpec) -> bool:
        """Start a process; what goes wrong is said on the console. Return whether it was started."""
        process = Process(spec, self._exited)
        self._processes[spec.label] = process
        if self._start(process):
            return True
        del self._processes[spec.label]
        return False

    def _start(self, process: Process) -> bool:
        spec = process.spec
        try:
            process.start()
        except OSError as error:
            self._console.error(f"cannot launch node of type [{spec.node}]: {error.strerror}: {error.filename}")
            return False
        self._console.bold(f"process[{spec.label}]: started with pid [{process.pid}]")
        return True

    def _exited(self, process: Process) -> None:
        self._events.put(("exit", process))

    def stop(self, reason: str = "") -> None:
        """Ask `run` to return; callable from any thread and from a signal handler. A second time hurries the end."""
        self._events.put(("hurry" if self._stopping else "stop", reason))
        self._stopping = True

    def run(self) -> str:
        """Watch until told to stop, a required process ended, or none is left; return the reason."""
        while True:
            if not self._processes and not self._keep_running:
                return "all processes on machine have died, roslaunch will exit"
            event = self._next_event()
            if event is None:
                self._respawn_due()
                continue
            kind, what = event
            if kind != "exit":
                return str(what or "")
            if isinstance(what, Process) and self._died(what):
                return "required process died"

    def _next_event(self) -> Event | None:
        timeout = None
        if self._respawns:
            timeout = max(0.0, min(self._respawns.values()) - time.monotonic())
        try:
            return self._events.get(timeout=timeout)
        except queue.Empty:
            return None

    def _died(self, process: Process) -> bool:
        """Say what happened and decide what follows; return whether everything has to end."""
        spec = process.spec
        log = f"\nlog file: {spec.log_base}*.log" if spec.log_base else ""
        if process.exit_code:
            text = f"process has died [pid {process.pid}, exit code {process.exit_code}, cmd {' '.join(spec.words)}]."
            self._console.plain_error(f"[{spec.label}] {text}{log}")
        else:
            self._console.bold(f"[{spec.label}] process has finished cleanly{log}")
        if spec.respawn:
            self._respawns[spec.label] = time.monotonic() + spec.respawn_delay
            return False
        self._retire(process)
        if spec.required:
            line = "=" * 80
            self._console.plain_error(f"{line}\nREQUIRED process [{spec.label}] has died!")
            self._console.plain_error(f"Initiating shutdown!\n{line}")
            return True
        return False

    def _retire(self, process: Process) -> None:
        process.join()
        del self._processes[process.spec.label]
        self._dead[process.spec.label] = process

    def _respawn_due(self) -> None:
        now = time.monotonic()
        for label in [label for label, due in self._respawns.items() if due <= now]:
            del self._respawns[label]
            process = self._processes[label]
            process.join()
            self._console.line(f"[{label}] restarting process")
            if not self._start(process):
                self._retire(process)

    def shut_down(self) -> None:
        """End all processes: SIGINT to all in reverse order, SIGTERM to the deaf, SIGKILL to the stuck."""
        self._stopping = True
        self._respawns.clear()
        running = [process for process in reversed(self.active) if process.alive]
        for process in running:
            self._console.line(f"[{process.spec.label}] killing on exit")
            process.signal(signal.SIGINT)
        running = self._wait(running, self._sigint_timeout)
        running = self._escalate(running, signal.SIGTERM, self._sigterm_timeout)
        running = self._escalate(running, signal.SIGKILL, _KILL_WAIT)
        for process in running:
            self._console.error(f"[{process.spec.label}] required SIGKILL. May still be running.")
        for process in self.active:
            if not process.alive:
                self._retire(process)

    def _escalate(self, running: list[Process], number: signal.Signals, seconds: float) -> list[Process]:
        for process in running:
            self._console.line(f"[{process.spec.label}] escalating to {number.name}")
            process.signal(number)
        return self._wait(running, seconds)

    def _wait(self, running: list[Process], seconds: float) -> list[Process]:
        """Wait for the processes; return those still running after `seconds`, or at once when a signal hurries us."""
        deadline = time.monotonic() + seconds
        while True:
            running = [process for process in running if process.alive]
            left = deadline - time.monotonic()
            if not running or left <= 0:
                return running
            try:
                kind, _ = self._events.get(timeout=left)
            except queue.Empty:
                continue
            if kind != "exit":
                return [process for process in running if process.alive]


def install_signals(stop: Callable[[str], None]) -> Callable[[], None]:
    """Let SIGINT, SIGTERM and SIGHUP call `stop` with the signal's name; return a function that undoes it."""
    old = {}
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None:
            old[number] = signal.signal(number, lambda received, frame: stop(signal.Signals(received).name))

    def restore() -> None:
        for number, handler in old.items():
            signal.signal(number, handler)

    return restore
