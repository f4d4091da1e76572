"""One supervised process: started in its own session, watched by a thread that sleeps until it ends."""

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
from pyros1.launch.running.usage import UNKNOWN, Usage
from pyros1.launch.running.warden import group_exists, leaderless

if TYPE_CHECKING:
    from pyros1.launch.running.screen import Screen
    from pyros1.launch.running.warden import Warden


@dataclass
class Process:
    """A started process.

    Args:
        spec: what it is.
        on_exit: called with this object on the watching thread when it has ended.
        warden: who ends it when this process is killed.
        screen: what writes its output to the screen with its name; None lets it write there itself.

    Attributes:
        spawn_count: how often it was started.
        exit_code: negative for a signal, None while it runs.
        started: monotonic time of the last start.
        held: stopped by the user, who may start it again.
        restarting: to be started again as soon as it has ended.
        machine: where it runs, empty for this machine.
        stranded: its machine cannot be reached now.
        due: it is to be started as soon as its machine is back.
    """

    spec: ProcessSpec
    on_exit: Callable[[Process], object]
    warden: Warden | None = None
    screen: Screen | None = None
    spawn_count: int = 0
    exit_code: int | None = None
    started: float = 0.0
    held: bool = False
    restarting: bool = False
    machine: str = ""
    stranded: bool = False
    due: bool = False
    _popen: subprocess.Popen[bytes] | None = None
    _ended: threading.Event = field(default_factory=threading.Event)
    _watcher: threading.Thread | None = None
    _remains: set[int] = field(default_factory=set)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    @property
    def pid(self) -> int:
        """Process id, 0 before the first start."""
        return self._popen.pid if self._popen is not None else 0

    @property
    def alive(self) -> bool:
        """Whether it runs."""
        return self._popen is not None and not self._ended.is_set()

    @property
    def gone(self) -> bool:
        """Whether it does not run, and nothing that any life of it has started in its group does."""
        return not self.alive and not self._groups()

    def _groups(self) -> set[int]:
        """The groups of former lives that still have members."""
        with self._lock:  # a life that ends right now adds to them
            known = set(self._remains)
        over = {pid for pid in known if not leaderless(pid)}
        with self._lock:
            self._remains -= over
            return set(self._remains)

    def start(self, announce: Callable[[Process], object] = lambda process: None) -> None:
        """Start it, or start it again.

        Args:
            announce: called with it at once, before anything that it says is read.

        Raises:
            OSError: it cannot be started.
        """
        spec = self.spec
        if self.warden is not None:
            self.warden.expect(spec.words[-1])
        with self._outputs() as (out, err):
            self._popen = _popen(spec, out, err)
            if self.warden is not None:  # first: who was told of it may kill us at once
                self.warden.watch(self._popen.pid)
            announce(self)
        self._ended = threading.Event()
        self.exit_code = None
        self.spawn_count += 1
        self.started = time.monotonic()
        self._watcher = threading.Thread(
            target=self._watch, args=(self._popen, self._ended), name=f"watch {spec.label}"
        )
        self._watcher.daemon = True
        self._watcher.start()

    @contextlib.contextmanager
    def _outputs(self) -> Iterator[tuple[int | None, int | None]]:
        """Yield where its standard output and error go, None for where ours go; a screen reads them afterwards."""
        spec = self.spec
        with contextlib.ExitStack() as files:
            if not spec.to_screen and spec.log_base is not None:
                os.makedirs(os.path.dirname(spec.log_base), exist_ok=True)
                # A restarted node must not erase what its predecessor said last.
                mode = "ab" if self.spawn_count else "wb"
                stdout = files.enter_context(open(f"{spec.log_base}-stdout.log", mode))
                if not spec.errors_to_file:
                    yield stdout.fileno(), None
                else:
                    yield stdout.fileno(), files.enter_context(open(f"{spec.log_base}-stderr.log", mode)).fileno()
            elif self.screen is not None:
                yield files.enter_context(self.screen.opened(spec))
            else:
                yield None, None

    def _watch(self, popen: subprocess.Popen[bytes], ended: threading.Event) -> None:
        self.exit_code = popen.wait()
        if group_exists(popen.pid):
            with self._lock:
                self._remains.add(popen.pid)
        if self.warden is not None:
            self.warden.ended(popen.pid)
        ended.set()
        self.on_exit(self)

    def signal(self, number: int) -> None:
        """Send a signal to the process and all that it started in its group."""
        popen = self._popen
        if popen is not None and not self._ended.is_set():
            try:
                os.killpg(popen.pid, number)
            except ProcessLookupError:
                pass
            except PermissionError:  # it became another user; perhaps the process itself still listens to us
                popen.send_signal(number)
        for group in self._groups():
            with contextlib.suppress(OSError):
                os.killpg(group, number)

    def usage(self, here: Mapping[int, Usage]) -> Usage:
        """What it uses.

        Args:
            here: what the process groups of this machine use.
        """
        return here.get(self.pid, UNKNOWN) if self.alive else UNKNOWN

    def wait(self, deadline: float) -> bool:
        """Wait until it has ended or `deadline` (monotonic seconds); return whether it has ended."""
        return self._popen is None or self._ended.wait(max(0.0, deadline - time.monotonic()))

    def join(self, timeout: float = 5.0) -> None:
        """Wait for the watching thread of an ended process."""
        if self._watcher is not None and self._watcher is not threading.current_thread():
            self._watcher.join(timeout)

    def kill(self) -> None:
        """End it at once."""
        self.signal(signal.SIGKILL)


def _popen(spec: ProcessSpec, out: int | None, err: int | None) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        spec.words, env=spec.env, cwd=spec.cwd, stdout=out, stderr=err, start_new_session=True, close_fds=True
    )
