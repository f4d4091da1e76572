"""A supervised process, started in a new session and watched by a thread that waits until it exits."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from pyros1.launch.running.process_spec import ProcessSpec
from pyros1.launch.running.usage import UNKNOWN_USAGE, Usage
from pyros1.launch.running.watchdog import HAS_PROCESS_GROUPS, group_exists, is_leaderless

if TYPE_CHECKING:
    from pyros1.launch.preload.preloader import ForkedProcess, Preloader
    from pyros1.launch.running.screen import Screen
    from pyros1.launch.running.watchdog import Watchdog

KILL_SIGNAL = getattr(signal, "SIGKILL", signal.SIGTERM)
"""A signal that no process can ignore."""


@dataclass
class Process:
    """A process to run, once or several times.

    Args:
        spec: the description of the process.
        on_exit: called with this object, in the watching thread, when the process has exited.
        watchdog: stops the process if the launcher is killed.
        screen: writes the process's output to the screen with its name; None to let it write directly.
        preloader: starts the process if it is a Python program that can be forked.

    Attributes:
        spawn_count: how many times the process has been started.
        exit_code: the exit code, negative for a signal; None while the process is running.
        started_at: time of the last start, in seconds of the monotonic clock.
        stopped_by_user: whether the user has stopped the process, and may start it again.
        is_restarting: whether to start the process again as soon as it has exited.
        machine: name of the process's machine; empty for this machine.
        is_disconnected: whether the machine is currently unreachable.
        is_restart_due: whether to start the process as soon as the machine can be reached again.
    """

    spec: ProcessSpec
    on_exit: Callable[[Process], object]
    watchdog: Watchdog | None = None
    screen: Screen | None = None
    preloader: Preloader | None = None
    spawn_count: int = 0
    exit_code: int | None = None
    started_at: float = 0.0
    stopped_by_user: bool = False
    is_restarting: bool = False
    machine: str = ""
    is_disconnected: bool = False
    is_restart_due: bool = False
    _popen: subprocess.Popen[bytes] | ForkedProcess | None = None
    _ended: threading.Event = field(default_factory=threading.Event)
    _watcher: threading.Thread | None = None
    _leftover_groups: set[int] = field(default_factory=set)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    @property
    def pid(self) -> int:
        """The process id; 0 before the first start."""
        return self._popen.pid if self._popen is not None else 0

    @property
    def alive(self) -> bool:
        """Whether the process is running."""
        return self._popen is not None and not self._ended.is_set()

    @property
    def is_gone(self) -> bool:
        """Whether the process and all members of its groups, including those of previous runs, have exited."""
        return not self.alive and not self._live_leftover_groups()

    def _live_leftover_groups(self) -> set[int]:
        """Forget the leftover groups that have become empty. Return the others, which still have members although
        their leader has exited.
        """
        with self._lock:  # the watching thread may be adding a group
            leftover_groups = set(self._leftover_groups)
        ended_groups = {pid for pid in leftover_groups if not is_leaderless(pid)}
        with self._lock:
            self._leftover_groups -= ended_groups
            return set(self._leftover_groups)

    def start(self, on_started: Callable[[Process], object] = lambda process: None) -> None:
        """Start the process, for the first time or again.

        Args:
            on_started: called with this object as soon as the process runs, before any of its output is read.

        Raises:
            OSError: the process cannot be started.
        """
        spec = self.spec
        if self.watchdog is not None:
            self.watchdog.expect(spec.words[-1])
        with self._outputs() as (out, err):
            self._popen = self._spawn(out, err)
            if self.watchdog is not None:  # before `on_started`: its callback may kill this launcher immediately
                on_death_spec = spec.on_death_spec
                on_death_command = (
                    None if on_death_spec is None else (on_death_spec.words, on_death_spec.env, on_death_spec.cwd)
                )
                self.watchdog.watch(self._popen.pid, on_death_command)
            if not isinstance(self._popen, subprocess.Popen):
                self._popen.begin()  # only now, since the watchdog cannot find a forked process by its command line
            on_started(self)
        self._ended = threading.Event()
        self.exit_code = None
        self.spawn_count += 1
        self.started_at = time.monotonic()
        self._watcher = threading.Thread(
            target=self._watch, args=(self._popen, self._ended), name=f"watch {spec.label}"
        )
        self._watcher.daemon = True
        self._watcher.start()

    @contextlib.contextmanager
    def _outputs(self) -> Iterator[tuple[int | None, int | None]]:
        """Yield descriptors for standard output and error; None to inherit this process's stream."""
        spec = self.spec
        with contextlib.ExitStack() as files:
            if not spec.to_screen and spec.log_base is not None:
                os.makedirs(os.path.dirname(spec.log_base), exist_ok=True)
                # A restarted node must not overwrite the output of its previous run.
                mode = "ab" if self.spawn_count else "wb"
                stdout = files.enter_context(open(f"{spec.log_base}-stdout.log", mode))
                if not spec.errors_to_file:
                    yield stdout.fileno(), None
                else:
                    yield stdout.fileno(), files.enter_context(open(f"{spec.log_base}-stderr.log", mode)).fileno()
            elif self.screen is not None:
                yield files.enter_context(self.screen.open_outputs(spec))
            else:
                yield None, None

    def _spawn(self, out: int | None, err: int | None) -> subprocess.Popen[bytes] | ForkedProcess:
        spec = self.spec
        if self.preloader is not None:
            outputs = (1 if out is None else out, 2 if err is None else err)
            forked = self.preloader.start(spec.words, spec.env, spec.cwd, *outputs)
            if forked is not None:
                return forked
        return subprocess.Popen(
            spec.words, env=spec.env, cwd=spec.cwd, stdout=out, stderr=err, start_new_session=True, close_fds=True
        )

    def _watch(self, popen: subprocess.Popen[bytes] | ForkedProcess, ended: threading.Event) -> None:
        self.exit_code = popen.wait()
        if group_exists(popen.pid):
            with self._lock:
                self._leftover_groups.add(popen.pid)
        if self.watchdog is not None:
            self.watchdog.report_exit(popen.pid)
        ended.set()
        self.on_exit(self)

    def signal(self, number: int) -> None:
        """Send a signal to the process group.

        On systems without process groups, SIGINT is ignored, since the process has received the terminal's Ctrl-C as
        well; any other signal terminates it immediately.
        """
        popen = self._popen
        if not HAS_PROCESS_GROUPS:
            if popen is not None and number != signal.SIGINT:
                popen.terminate()
        elif popen is not None and not self._ended.is_set():
            try:
                os.killpg(popen.pid, number)
            except ProcessLookupError:
                pass
            except PermissionError:  # a member has changed its user; the process itself may still accept signals
                popen.send_signal(number)
        for group in self._live_leftover_groups():
            with contextlib.suppress(OSError):
                os.killpg(group, number)

    def usage(self, local_usages: Mapping[int, Usage]) -> Usage:
        """Return the CPU and memory usage.

        Args:
            local_usages: usage of the process groups on this machine, by group id.
        """
        return local_usages.get(self.pid, UNKNOWN_USAGE) if self.alive else UNKNOWN_USAGE

    def wait(self, deadline: float) -> bool:
        """Wait until the process has exited, up to ``deadline`` in monotonic seconds; return whether it has exited."""
        return self._popen is None or self._ended.wait(max(0.0, deadline - time.monotonic()))

    def join(self, timeout: float = 5.0) -> None:
        """Wait until the watching thread of an exited process has finished."""
        if self._watcher is not None and self._watcher is not threading.current_thread():
            self._watcher.join(timeout)

    def kill(self) -> None:
        """Kill the process immediately."""
        self.signal(KILL_SIGNAL)
