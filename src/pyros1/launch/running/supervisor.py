"""Starts, supervises, restarts and stops processes as their specs say (X87-X90).

All events go through one queue: a process has exited, a signal was received, a client shut down the master, or a user
stopped a node. The thread in `run` waits for an event or a timer, and meanwhile checks for signals
(`pyros1.net.signal_safe`). Nothing else is polled, except for the remaining members of an exited node's process group,
since only their parent could wait for them.
"""

from __future__ import annotations

import queue
import signal
import time
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Literal, NamedTuple

from pyros1.ground.errors import LaunchError, NodeError
from pyros1.ground.interrupts import InterruptCounter, install_handler
from pyros1.ground.realtime import set_priority
from pyros1.launch.running.console import Console
from pyros1.launch.running.process import KILL_SIGNAL, Process
from pyros1.launch.running.process_spec import ProcessSpec
from pyros1.launch.running.screen import Screen
from pyros1.launch.running.watchdog import HAS_PROCESS_GROUPS, ON_DEATH_TIMEOUT, Watchdog
from pyros1.net.signal_safe import POLL_INTERVAL

if TYPE_CHECKING:
    from pyros1.launch.preload.preloader import Preloader

_SIGKILL_TIMEOUT = 2.0
_NO_SIGINT_TIMEOUT = 2.0  # seconds for processes to exit on systems where they cannot be sent SIGINT
_REMAINING_POLL_INTERVAL = 0.05
Event = tuple[Literal["exit", "stop", "hurry", "call"], "_Exit | str | Callable[[], object] | None"]


class _Exit(NamedTuple):
    """The exit of a process, with the number of the run: the process may be restarted before the event is handled."""

    process: Process
    run_number: int


class Supervisor:
    """Starts and supervises processes.

    Args:
        console: prints lines for the user.
        sigint_timeout: seconds between SIGINT and SIGTERM.
        sigterm_timeout: seconds between SIGTERM and SIGKILL.
        keep_running: whether to continue when no process is left, as a core does.
        guarded: whether to start a `Watchdog`, which stops the processes if this process is killed.
        screen: writes the processes' output to the screen; None to let them write directly.
        preloader: starts Python programs by forking; None to start all programs in the usual way.

    Attributes:
        required_failed: whether a required process has exited with an error.
        num_expected: number of processes that have not been started yet.
        keep_running: whether to continue when no process is left.
        on_process_exit: called with each process that exits during `run`; may be None.
    """

    def __init__(
        self,
        console: Console,
        *,
        sigint_timeout: float = 15.0,
        sigterm_timeout: float = 2.0,
        keep_running: bool = False,
        guarded: bool = False,
        screen: Screen | None = None,
        preloader: Preloader | None = None,
    ) -> None:
        self._console = console
        self._stages = [
            (signal.SIGINT, sigint_timeout if HAS_PROCESS_GROUPS else min(sigint_timeout, _NO_SIGINT_TIMEOUT)),
            (signal.SIGTERM, sigterm_timeout),
            (KILL_SIGNAL, _SIGKILL_TIMEOUT),
        ]
        self._guarded = guarded and HAS_PROCESS_GROUPS
        self._watchdog: Watchdog | None = None
        self._screen = screen
        self._preloader = preloader
        # A SimpleQueue is safe in signal handlers, whatever the main thread was doing.
        self._events: queue.SimpleQueue[Event] = queue.SimpleQueue()
        self._timers: dict[str, tuple[float, Callable[[], object]]] = {}
        self._rerun_on_death: set[str] = set()  # labels of running on-death processes that are to run again
        self._processes: dict[str, Process] = {}
        self._dead: dict[str, Process] = {}
        self.required_failed = False
        self.num_expected = 0
        self.keep_running = keep_running
        self.on_process_exit: Callable[[Process], object] | None = None

    @property
    def active(self) -> list[Process]:
        """The processes that are running or may be respawned, in the order in which they were started."""
        return list(self._processes.values())

    @property
    def dead(self) -> list[Process]:
        """The processes that have exited and will not be respawned."""
        return list(self._dead.values())

    def start(self, spec: ProcessSpec, make_process: Callable[..., Process] = Process) -> bool:
        """Start a process and return whether it was started. Errors are printed on the console.

        Args:
            spec: the description of the process.
            make_process: the class `Process`, or a function with the same arguments that creates a similar object.
        """
        if self._guarded and self._watchdog is None:
            self._watchdog = Watchdog(self._stages[0][1], self._stages[1][1])
        process = make_process(spec, self._on_exit, self._watchdog, self._screen)
        process.preloader = self._preloader
        self._processes[spec.label] = process
        if self._start(process):
            return True
        del self._processes[spec.label]
        return False

    def _start(self, process: Process) -> bool:
        spec = process.spec
        try:
            process.start(self._print_start)
        except OSError as error:
            self._console.error(f"cannot start [{spec.label}]: {error.strerror}: {error.filename}")
            return False
        return True

    def _print_start(self, process: Process) -> None:
        spec = process.spec
        self._console.bold(f"process[{spec.label}]: started with pid [{process.pid}]")
        if spec.priority and not process.machine:
            try:
                set_priority(spec.priority, process.pid)
            except NodeError as error:
                self._console.error(f"[{spec.label}] {error}. The node runs without it")

    def _on_exit(self, process: Process) -> None:
        self._events.put(("exit", _Exit(process, process.spawn_count)))

    def stop(self, reason: str = "") -> None:
        """Make `run` return. May be called in any thread or signal handler."""
        self._events.put(("stop", reason))

    def stop_waiting(self) -> None:
        """Stop waiting for processes to exit, and send the next signal now. May be called in any thread or signal
        handler.
        """
        self._events.put(("hurry", None))

    def call_soon(self, action: Callable[[], object]) -> None:
        """Call a function in the thread of `run`. May be called in any thread."""
        self._events.put(("call", action))

    def run(self) -> str:
        """Supervise until `stop` is called, a required process exits, or no process is left; return the reason."""
        while True:
            if not self._processes and not self.keep_running and not self.num_expected:
                return "all processes on machine have died, roslaunch will exit"
            event = self._next_event()
            if event is None:
                self._run_due_timers()
                continue
            event_kind, payload = event
            if event_kind == "stop":
                return str(payload or "")
            if event_kind == "call" and callable(payload):
                payload()
            elif (
                isinstance(payload, _Exit)
                and payload.run_number == payload.process.spawn_count
                and self._handle_exit(payload.process)
            ):
                return "required process died"

    def _next_event(self) -> Event | None:
        timeout = POLL_INTERVAL
        if self._timers:
            timeout = max(
                0.0, min(POLL_INTERVAL, min(due_at for due_at, _ in self._timers.values()) - time.monotonic())
            )
        try:
            return self._events.get(timeout=timeout)
        except queue.Empty:
            return None

    def _run_due_timers(self) -> None:
        now = time.monotonic()
        for key, (due_at, action) in list(self._timers.items()):
            if due_at <= now:
                del self._timers[key]
                action()

    def stop_after(self, seconds: float, reason: str) -> None:
        """Make `run` return ``reason`` after `seconds`, unless it returns earlier."""
        self._schedule("", seconds, lambda: self._events.put(("stop", reason)))

    def _schedule(self, key: str, seconds: float, action: Callable[[], object]) -> None:
        self._timers[key] = (time.monotonic() + seconds, action)

    def _handle_exit(self, process: Process) -> bool:
        """Report the exit of a process and react to it; return whether the launch must be shut down."""
        spec = process.spec
        if self.on_process_exit is not None:
            self.on_process_exit(process)
        log_hint = f"\nlog file: {spec.log_base}*.log" if spec.log_base else ""
        if process.stopped_by_user or process.is_restarting:
            self._finish_stop(process)
            return False
        if process.exit_code:
            text = f"process has died [pid {process.pid}, exit code {process.exit_code}, cmd {' '.join(spec.words)}]."
            self._console.plain_error(f"[{spec.label}] {text}{log_hint}")
        else:
            self._console.bold(f"[{spec.label}] process has finished cleanly{log_hint}")
        is_on_death_running = spec.on_death_spec is not None and self._run_on_death(spec, spec.on_death_spec)
        if spec.ends_launch:
            self._mark_dead(process)
            return True
        if spec.exit_policy.respawn and process.is_disconnected:
            process.is_restart_due = True
            return False
        if spec.exit_policy.respawn:
            process.signal(signal.SIGTERM)  # otherwise, processes that are left behind would accumulate with each run
            self._schedule(spec.label, spec.exit_policy.respawn_delay, lambda: self._respawn(process))
            return False
        self._mark_dead(process)
        if spec.exit_policy.required:
            self.required_failed = bool(process.exit_code)
            line = "=" * 80
            self._console.plain_error(f"{line}\nREQUIRED process [{spec.label}] has died!")
            self._console.plain_error(f"Initiating shutdown!\n{line}")
            if is_on_death_running:  # the launch is shut down when the on-death process exits
                self._schedule(
                    " on-death", ON_DEATH_TIMEOUT, lambda: self._events.put(("stop", "required process died"))
                )
            return not is_on_death_running
        if spec.label in self._rerun_on_death:  # the on-death process's node died again while it ran
            self._rerun_on_death.discard(spec.label)
            self._dead.pop(spec.label, None)
            self.start(spec)
        return False

    def _run_on_death(self, spec: ProcessSpec, on_death_spec: ProcessSpec) -> bool:
        """Start the on-death process of a process; return whether the on-death process is running.

        If it is still running after an earlier exit, it is not interrupted: otherwise, it would never finish if
        the node keeps dying. It is restarted when it has exited, or after ON_DEATH_TIMEOUT.
        """
        self._console.line(f"[{spec.label}] on-death: {' '.join(on_death_spec.words)}")
        running_process = self._processes.get(on_death_spec.label)
        if running_process is not None:
            if on_death_spec.label not in self._rerun_on_death:
                self._rerun_on_death.add(on_death_spec.label)
                self._schedule(
                    f" again {on_death_spec.label}",
                    ON_DEATH_TIMEOUT,
                    lambda: self._rerun_on_death_command(on_death_spec.label),
                )
            return True
        self._dead.pop(on_death_spec.label, None)
        return self.start(on_death_spec)

    def _rerun_on_death_command(self, label: str) -> None:
        running_process = self._processes.get(label)
        if label in self._rerun_on_death and running_process is not None:
            self._rerun_on_death.discard(label)
            self.restart_node(running_process)

    def _mark_dead(self, process: Process) -> None:
        process.join()
        del self._processes[process.spec.label]
        self._dead[process.spec.label] = process

    def _respawn(self, process: Process) -> None:
        process.kill()
        self._restart(process)

    def _restart(self, process: Process) -> None:
        process.join()
        process.is_restart_due = process.is_disconnected
        if process.is_restart_due:
            self._console.line(f"[{process.spec.label}] waiting for machine [{process.machine}]")
            return
        self._console.line(f"[{process.spec.label}] restarting process")
        if not self._start(process):
            process.is_restart_due = process.is_disconnected and process.spec.exit_policy.respawn
            if not process.is_restart_due:
                self._mark_dead(process)

    def resume(self, processes: Iterable[Process]) -> None:
        """Start the given processes that are due to be restarted, since their machine is connected again.

        Must be called in the thread of `run`.
        """
        for process in processes:
            process.is_disconnected = False
            if process.is_restart_due and not process.stopped_by_user:
                self._restart(process)

    # User requests while it runs --------------------------------------------------------------------------------------

    def find(self, name: str) -> Process:
        """Return the process with the given label, or of the given node.

        Raises:
            LaunchError: there is no such process.
        """
        for process in [*self.active, *self.dead]:
            if name in (process.spec.node, process.spec.label):
                return process
        raise LaunchError(f"this launch has no node [{name}]")

    def stop_node(self, process: Process) -> None:
        """Stop a process until it is started again. Must be called in the thread of `run`."""
        process.stopped_by_user, process.is_restarting = True, False
        self._stop_process(process)

    def end_node(self, process: Process) -> None:
        """Stop a process as if it had exited by itself: it may be respawned. Must be called in the thread of `run`."""
        is_stopping = process.stopped_by_user or process.is_restarting
        if not (process.alive or is_stopping) and process.spec.label in self._timers:
            return  # it has exited, and will be respawned
        process.stopped_by_user = process.is_restarting = False
        self._stop_process(process)

    def start_node(self, process: Process) -> None:
        """Start a process that was stopped or has exited. Must be called in the thread of `run`."""
        process.is_restarting = process.alive and (process.stopped_by_user or process.is_restarting)
        process.stopped_by_user = False
        if not process.alive:
            self._timers.pop(process.spec.label, None)
            self._dead.pop(process.spec.label, None)
            self._processes[process.spec.label] = process
            self._restart(process)

    def restart_node(self, process: Process) -> None:
        """Stop a process and start it again. Must be called in the thread of `run`."""
        if not process.alive:
            self.start_node(process)
            return
        process.stopped_by_user, process.is_restarting = False, True
        self._stop_process(process)

    def _stop_process(self, process: Process, stage: int = 0) -> None:
        """Send the signal of a stage, and later the signal of the next stage if the process is still running."""
        self._timers.pop(process.spec.label, None)
        if process.is_gone or stage == len(self._stages):
            return
        signal_number, seconds = self._stages[stage]
        action_text = "stopping" if not stage else f"escalating to {signal_number.name}"
        self._console.line(f"[{process.spec.label}] {action_text}")
        process.signal(signal_number)
        self._schedule(process.spec.label, seconds, lambda: self._stop_process(process, stage + 1))

    def _finish_stop(self, process: Process) -> None:
        """Handle the exit of a process that was stopped: wait for its children, and restart it if requested."""
        if not process.is_gone and process.spec.label in self._timers:
            self._schedule(
                f"{process.spec.label} remains", _REMAINING_POLL_INTERVAL, lambda: self._finish_stop(process)
            )
            return
        self._timers.pop(process.spec.label, None)
        if process.is_restarting:
            process.is_restarting = False
            self._restart(process)
        else:
            self._console.bold(f"[{process.spec.label}] stopped")

    # Shutdown --------------------------------------------------------------------------------------------------------

    def shut_down(self) -> None:
        """Stop all processes: send SIGINT in reverse order, then SIGTERM and SIGKILL to those still running."""
        self._timers.clear()
        running = [process for process in reversed([*self.dead, *self.active]) if not process.is_gone]
        for stage, (signal_number, seconds) in enumerate(self._stages):
            for process in running:
                if stage or process.alive:
                    action_text = f"escalating to {signal_number.name}" if stage else "killing on exit"
                    self._console.line(f"[{process.spec.label}] {action_text}")
                process.signal(signal_number)
            running = self._wait(running, seconds)
        for process in running:
            self._console.error(f"[{process.spec.label}] required SIGKILL. May still be running.")
        for process in self.active:
            if not process.alive:
                self._mark_dead(process)
        if self._watchdog is not None:
            self._watchdog.close()
            self._watchdog = None
        if self._preloader is not None:
            self._preloader.close()

    def _wait(self, running: list[Process], seconds: float) -> list[Process]:
        """Wait for processes to exit; return those still running after `seconds`, or after `stop_waiting`."""
        deadline = time.monotonic() + seconds
        while True:
            running = [process for process in running if not process.is_gone]
            remaining = min(POLL_INTERVAL, deadline - time.monotonic())
            if not running or remaining <= 0:
                return running
            if not any(process.alive for process in running):
                remaining = min(remaining, _REMAINING_POLL_INTERVAL)
            try:
                event_kind, _ = self._events.get(timeout=remaining)
            except queue.Empty:
                continue
            if event_kind == "hurry":
                return [process for process in running if not process.is_gone]


def install_signals(
    stop: Callable[[str], object], stop_waiting: Callable[[], object] = lambda: None
) -> Callable[[], None]:
    """Install signal handlers that stop a launch.

    Args:
        stop: called with the name of the first signal.
        stop_waiting: called for each later signal that a user may have sent, see `InterruptCounter`.

    Returns:
        A function that removes the handlers.
    """
    interrupts = InterruptCounter()

    def handle(number: int, frame: object) -> None:
        if not interrupts.count_signal():
            return
        if interrupts.count == 1:
            stop(signal.Signals(number).name)
        else:
            stop_waiting()

    return install_handler(handle)
