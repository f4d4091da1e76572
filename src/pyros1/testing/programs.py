"""Programs that run during a test."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Mapping, Sequence

from pyros1.testing.heard import DEFAULT_TIMEOUT

MAX_OUTPUT = 1_000_000
"""Maximum number of characters of a program's output that are kept. Of longer output, the beginning is discarded."""
STOP_TIMEOUTS = (10.0, 3.0, 10.0)
"""Seconds to wait for a program to exit after SIGINT, SIGTERM and SIGKILL, respectively."""


class Program:
    """A process whose output a test can wait for. The process has its own session, so that its child processes can be
    killed as well.

    Args:
        words: the command line.
        environ: the program's environment variables.
    """

    def __init__(self, words: Sequence[str], environ: Mapping[str, str]) -> None:
        self.words = list(words)
        self._changed = threading.Condition()
        self._output = ""
        self._output_ended = False
        self._process = subprocess.Popen(
            self.words,
            env={**environ, "PYTHONUNBUFFERED": "1"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        self._reader = threading.Thread(target=self._read_output, name=f"output of {self.words[-1]}", daemon=True)
        self._reader.start()

    def _read_output(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as pipe:
            while data := os.read(pipe.fileno(), 65536):
                with self._changed:
                    self._output = (self._output + data.decode("utf-8", "replace"))[-MAX_OUTPUT:]
                    self._changed.notify_all()
        with self._changed:
            self._output_ended = True
            self._changed.notify_all()

    @property
    def output(self) -> str:
        """The program's output so far, from standard output and standard error: the last million characters."""
        with self._changed:
            return self._output

    @property
    def running(self) -> bool:
        """Whether the program is still running."""
        return self._process.poll() is None

    def wait_for(self, pattern: str, timeout: float = DEFAULT_TIMEOUT) -> re.Match[str]:
        """Wait until the program's output matches a pattern; return the match.

        Args:
            pattern: a regular expression, used with `re.search` on the whole output; ``^`` and ``$`` match at the start
                and end of each line.
            timeout: maximum number of seconds to wait.

        Raises:
            AssertionError: the program exited without a match, or there was no match in time; the message contains the
                output.
        """
        regex = re.compile(pattern, re.MULTILINE)
        with self._changed:
            self._changed.wait_for(lambda: regex.search(self._output) or self._output_ended, timeout)
            match = regex.search(self._output)
            if match:
                return match
            problem = "exited without printing" if self._output_ended else f"did not print within {timeout:g} s"
            raise AssertionError(f"{' '.join(self.words)}\n{problem} {pattern!r}, but:\n{self._output or '(nothing)'}")

    def wait(self, timeout: float = DEFAULT_TIMEOUT) -> int:
        """Wait until the program exits.

        Args:
            timeout: maximum number of seconds to wait.

        Returns:
            The exit code; the negative signal number if a signal killed the program.

        Raises:
            AssertionError: the program is still running after the timeout.
        """
        try:
            return self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            raise AssertionError(
                f"{' '.join(self.words)}\nis still running after {timeout:g} s:\n{self.output}"
            ) from None

    def stop(self) -> int:
        """Interrupt the program like Ctrl-C, and kill it if it does not exit. It may already have exited.

        Returns:
            The exit code; the negative signal number if a signal killed the program.
        """
        actions = (self._interrupt, self._process.terminate, self._process.kill)
        for stop, timeout in zip(actions, STOP_TIMEOUTS, strict=True):
            if not self.running:
                break
            stop()
            try:
                self._process.wait(timeout)
            except subprocess.TimeoutExpired:
                continue
        self._kill_group()
        self._reader.join(5.0)
        return self._process.wait(0)

    def _interrupt(self) -> None:
        if sys.platform == "win32":
            self._process.terminate()
        else:
            self._process.send_signal(signal.SIGINT)

    def _kill_group(self) -> None:
        """Kill the processes that the program has started and left behind."""
        if sys.platform == "win32":
            return
        try:
            os.killpg(self._process.pid, signal.SIGKILL)
        except (ProcessLookupError, PermissionError):  # no process is left (PermissionError on macOS)
            return


def pyros1_command(*words: str) -> list[str]:
    """Return the command line of a pyros1 command."""
    return [sys.executable, "-m", "pyros1", *words]
