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
"""Maximum number of characters kept of a program's output; the beginning is discarded."""
STOP_TIMEOUTS = (10.0, 3.0, 10.0)
"""Seconds that a program may take to exit after SIGINT, SIGTERM and SIGKILL."""


class Program:
    """A process whose output a test can wait for. It has its own session: all its processes are ended with the test.

    Args:
        words: the command line.
        environ: its environment variables.
    """

    def __init__(self, words: Sequence[str], environ: Mapping[str, str]) -> None:
        self.words = list(words)
        self._changed = threading.Condition()
        self._text = ""
        self._closed = False
        self._process = subprocess.Popen(
            self.words,
            env={**environ, "PYTHONUNBUFFERED": "1"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        self._reader = threading.Thread(target=self._read, name=f"output of {self.words[-1]}", daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as pipe:
            while data := os.read(pipe.fileno(), 65536):
                with self._changed:
                    self._text = (self._text + data.decode("utf-8", "replace"))[-MAX_OUTPUT:]
                    self._changed.notify_all()
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    @property
    def output(self) -> str:
        """Its output so far, on standard output and standard error: the last million characters."""
        with self._changed:
            return self._text

    @property
    def running(self) -> bool:
        """Whether it is still running."""
        return self._process.poll() is None

    def wait_for(self, pattern: str, timeout: float = DEFAULT_TIMEOUT) -> re.Match[str]:
        """Wait until it has printed a text.

        Args:
            pattern: a regular expression, searched by `re.search` in the whole output; ``^`` and ``$`` match at
                each line.
            timeout: seconds.

        Raises:
            AssertionError: it exited without printing it, or did not print it in time; the text contains its output.
        """
        wanted = re.compile(pattern, re.MULTILINE)
        with self._changed:
            self._changed.wait_for(lambda: wanted.search(self._text) or self._closed, timeout)
            found = wanted.search(self._text)
            if found:
                return found
            why = "exited without printing" if self._closed else f"did not print within {timeout:g} s"
            raise AssertionError(f"{' '.join(self.words)}\n{why} {pattern!r}, but:\n{self._text or '(nothing)'}")

    def wait(self, timeout: float = DEFAULT_TIMEOUT) -> int:
        """Wait until it exits.

        Args:
            timeout: seconds.

        Returns:
            The exit code; negative: the signal that ended it.

        Raises:
            AssertionError: it is still running.
        """
        try:
            return self._process.wait(timeout)
        except subprocess.TimeoutExpired:
            raise AssertionError(
                f"{' '.join(self.words)}\nis still running after {timeout:g} s:\n{self.output}"
            ) from None

    def stop(self) -> int:
        """End it like Ctrl-C; by force if it does not exit within 10 seconds. It may have exited already.

        Returns:
            The exit code; negative: the signal that ended it.
        """
        ways = (self._interrupt, self._process.terminate, self._process.kill)
        for end, grace in zip(ways, STOP_TIMEOUTS, strict=True):
            if not self.running:
                break
            end()
            try:
                self._process.wait(grace)
            except subprocess.TimeoutExpired:
                continue
        self._end_group()
        self._reader.join(5.0)
        return self._process.wait(0)

    def _interrupt(self) -> None:
        if sys.platform == "win32":
            self._process.terminate()
        else:
            self._process.send_signal(signal.SIGINT)

    def _end_group(self) -> None:
        """End the processes that it has started and left behind."""
        if sys.platform == "win32":
            return
        try:
            os.killpg(self._process.pid, signal.SIGKILL)
        except (ProcessLookupError, PermissionError):  # no process is left; macOS raises the latter
            return


def pyros1_command(*words: str) -> list[str]:
    """Return the command line of a pyros1 command."""
    return [sys.executable, "-m", "pyros1", *words]
