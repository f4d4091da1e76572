"""One supervised process: started in its own session, watched by a thread that sleeps until it ends."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field


@dataclass
class ProcessSpec:
    """What to start and how to treat it.

    Attributes:
        label: unique name, ``ns/name-<counter>``.
        node: full node name.
        words: command line.
        env: whole environment.
        cwd: working directory.
        log_base: path of its log files without ``.log``, None for none.
        to_screen: inherit stdout; else it goes to ``<log_base>-stdout.log``.
        respawn: start it again whenever it ends.
        respawn_delay: seconds before that.
        required: everything ends when it ends.
    """

    label: str
    node: str
    words: list[str]
    env: dict[str, str]
    cwd: str
    log_base: str | None = None
    to_screen: bool = True
    respawn: bool = False
    respawn_delay: float = 0.0
    required: bool = False


@dataclass
class Process:
    """A started process.

    Args:
        spec: what it is.
        on_exit: called with this object on the watching thread when it has ended.

    Attributes:
        spawn_count: how often it was started.
        exit_code: negative for a signal, None while it runs.
        started: monotonic time of the last start.
    """

    spec: ProcessSpec
    on_exit: Callable[[Process], object]
    spawn_count: int = 0
    exit_code: int | None = None
    started: float = 0.0
    _popen: subprocess.Popen[bytes] | None = None
    _ended: threading.Event = field(default_factory=threading.Event)
    _watcher: threading.Thread | None = None

    @property
    def pid(self) -> int:
        """Process id, 0 before the first start."""
        return self._popen.pid if self._popen is not None else 0

    @property
    def alive(self) -> bool:
        """Whether it runs."""
        return self._popen is not None and not self._ended.is_set()

    def start(self) -> None:
        """Start it, or start it again.

        Raises:
            OSError: it cannot be started.
        """
        spec = self.spec
        stdout = None
        if not spec.to_screen and spec.log_base is not None:
            os.makedirs(os.path.dirname(spec.log_base), exist_ok=True)
            # A restarted node must not erase what its predecessor said last.
            stdout = open(f"{spec.log_base}-stdout.log", "ab" if self.spawn_count else "wb")  # noqa: SIM115 - closed below
        try:
            self._popen = subprocess.Popen(
                spec.words, env=spec.env, cwd=spec.cwd, stdout=stdout, start_new_session=True, close_fds=True
            )
        finally:
            if stdout is not None:
                stdout.close()
        self._ended = threading.Event()
        self.exit_code = None
        self.spawn_count += 1
        self.started = time.monotonic()
        self._watcher = threading.Thread(
            target=self._watch, args=(self._popen, self._ended), name=f"watch {spec.label}"
        )
        self._watcher.daemon = True
        self._watcher.start()

    def _watch(self, popen: subprocess.Popen[bytes], ended: threading.Event) -> None:
        self.exit_code = popen.wait()
        ended.set()
        self.on_exit(self)

    def signal(self, number: int) -> None:
        """Send a signal to the process and all that it started in its group."""
        popen = self._popen
        if popen is None or self._ended.is_set():
            return
        try:
            os.killpg(popen.pid, number)
        except ProcessLookupError:
            return
        except PermissionError:  # it became another user; perhaps the process itself still listens to us
            popen.send_signal(number)

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
