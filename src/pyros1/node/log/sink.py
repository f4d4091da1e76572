"""The sink of a node's log messages: the terminal in rosconsole's format, the log file and /rosout.

What the program logs is written before the call returns, so it is on the screen even if the program crashes in the
next line. Log messages of pyros1 itself are written by separate threads: a paused terminal, a full pipe or a slow
disk must not keep the node from registering, receiving and serving. All threads except the loop wait briefly until
they are written, so that the lines are normally in order.

Implements https://wiki.ros.org/rospy/Overview/Logging and https://wiki.ros.org/rosconsole (ROSCONSOLE_FORMAT).
"""

from __future__ import annotations

import contextlib
import os
import re
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, MutableMapping
from typing import NamedTuple, TextIO

from pyros1.ground import terminal_text
from pyros1.ground.log_file import LogFile
from pyros1.ground.timing import Time
from pyros1.net.background_writer import BackgroundWriter, Item, ShouldStop, write_to_terminal
from pyros1.net.loop import LoopThread
from pyros1.net.rate_limit import RepeatCounter
from pyros1.node.log.levels import DEBUG, ERROR, FATAL, INFO, NAMES, WARN

DEFAULT_FORMAT = "[${severity}] [${time}]: ${message}"
MAX_FILE_SIZE = 50_000_000
BACKUPS = 4
_COLOURS = {DEBUG: "\x1b[32m", WARN: "\x1b[33m", ERROR: "\x1b[31m", FATAL: "\x1b[31m"}
_TOKEN = re.compile(r"\$\{(\w+)(?::([^}]*))?\}")
_FILE_NAMES = {**NAMES, WARN: "WARNING", FATAL: "CRITICAL"}  # stock's log files use Python's level names
_MAX_PENDING = 100


class Record(NamedTuple):
    """One log message.

    Attributes:
        level: 1, 2, 4, 8 or 16, as rosgraph_msgs/Log.
        text: the message, with its arguments filled in.
        logger: name of the logger, ``rosout`` or below it.
        file, line, function: where it was logged; the file name without its folder.
        wall: seconds since the epoch.
        stamp: the node's time (simulated, if it runs on simulated time).
        path: the file's full path.
    """

    level: int
    text: str
    logger: str
    file: str
    line: int
    function: str
    wall: float
    stamp: Time
    path: str = ""


class Destinations(NamedTuple):
    """The places to which a record is written."""

    terminal: bool = True
    file: bool = True
    rosout: bool = True


ALL_DESTINATIONS = Destinations()
NO_TERMINAL = Destinations(terminal=False)


class _ThreadState(threading.local):
    """State of a thread that is writing to a sink.

    Attributes:
        writing: whether it is writing a record.
        waiting: records to write.
    """

    def __init__(self) -> None:
        self.writing = False
        self.waiting: deque[tuple[Record, bool, Destinations, bool]] = deque()


class LogSink:
    """Sink of a node's log messages: terminal, file and /rosout; shared by all its loggers.

    Args:
        node_name: full name.
        environ: environment variables; ROSCONSOLE_FORMAT is used.
        file_path: the log file, created with its folder when the first line is written; None for no file.
        now: returns (time, whether it is simulated).
        schedule: ``schedule(seconds, function, argument)`` calls a function after a delay; None: counts of
            repeated messages are written at the end.
    """

    def __init__(
        self,
        node_name: str,
        environ: Mapping[str, str],
        file_path: str | None,
        now: Callable[[], tuple[Time, bool]],
        schedule: Callable[..., object] | None = None,
    ) -> None:
        self.node_name = node_name
        self.now = now
        self.levels: MutableMapping[str, int] = {}
        self.explain: Callable[[BaseException], str] | None = None
        self.seen: dict[tuple[str, int], float] = {}
        self.publish: Callable[[Record], None] | None = None
        self._later = schedule or (lambda *_: None)
        self._format = environ.get("ROSCONSOLE_FORMAT") or DEFAULT_FORMAT
        self._file = LogFile(file_path, MAX_FILE_SIZE, BACKUPS) if file_path else None
        self._thread_state = _ThreadState()
        self._inherited_file: LogFile | None = None  # of the process that created it
        self._make_locks()

    def _make_locks(self) -> None:
        self._lock = threading.Lock()
        self.repeats = RepeatCounter(self._later)
        self._terminal_thread = BackgroundWriter(f"{self.node_name}:log", write_to_terminal)
        self._file_thread = BackgroundWriter(f"{self.node_name}:log file", self._write_items)
        self._pid = os.getpid()

    def reset_after_fork(self) -> None:
        """Prepare for use in a forked process, where locks may be held by threads that do not exist there."""
        if os.getpid() != self._pid:
            if self._file is not None:
                self._inherited_file, self._file = (
                    self._file,
                    self._file.reopened(),
                )  # it has a lock as well, on which closing would block
            self._make_locks()

    def emit(
        self, record: Record, simulated: bool, destinations: Destinations = ALL_DESTINATIONS, by_program: bool = True
    ) -> None:
        """Write a record. An error of a destination (a full disk, a closed pipe) does not stop the node.

        Args:
            record: what was logged.
            simulated: whether its stamp is simulated time.
            destinations: where to write it.
            by_program: whether the program, not pyros1, logs it: the call then waits until it is written.

        A signal handler may log on top of this function: its record is written when the function continues.
        """
        self.reset_after_fork()
        state = self._thread_state
        state.waiting.append((record, simulated, destinations, by_program))
        if state.writing:
            return
        for _ in range(_MAX_PENDING):  # a limit: writing may cause new records, and must not continue forever
            if not state.waiting:
                return
            try:
                state.writing = True
                self._write(*state.waiting.popleft())
            finally:
                state.writing = False  # then check again: a handler may have seen it while it was still true

    def _write(self, record: Record, simulated: bool, destinations: Destinations, by_program: bool) -> None:
        on_loop = isinstance(threading.current_thread(), LoopThread)
        may_wait = by_program and not on_loop
        if may_wait:
            self._flush()  # earlier messages of pyros1 come first
        if destinations.terminal:
            self._write_to_terminal(record, simulated, may_wait)
        if destinations.file and self._file is not None:
            line = self._file_line(record)
            if may_wait:
                self._write_file(line)
            else:
                self._file_thread.write("", line)
        if destinations.rosout and self.publish is not None:
            try:
                self.publish(record)
            except Exception as error:  # noqa: BLE001 - for example when no more files can be opened
                self._terminal_thread.write(
                    "stderr", terminal_text.lines(f"WARNING: cannot publish a log message on /rosout: {error}\n")
                )
        if not on_loop:
            self._flush()

    def _flush(self) -> None:
        self._terminal_thread.flush()
        self._file_thread.flush()

    def _write_to_terminal(self, record: Record, simulated: bool, may_wait: bool) -> None:
        where = "stdout" if record.level <= INFO else "stderr"
        stream = getattr(sys, where)
        text = terminal_text.coloured_lines(self.format(record, simulated)) + "\n"
        with contextlib.suppress(OSError, ValueError, AttributeError):
            colour = _COLOURS.get(record.level) if stream.isatty() else None
            if colour:
                text = f"{colour}{text[:-1]}\x1b[0m\n"
            if may_wait:
                _write_line(stream, text)
            else:
                self._terminal_thread.write(where, text)

    def format(self, record: Record, simulated: bool) -> str:
        """Return the record formatted by ROSCONSOLE_FORMAT (N31)."""
        wall = f"{record.wall:.6f}"

        def replace(token: re.Match[str]) -> str:
            name, strftime = token.group(1), token.group(2)
            if name in ("time", "walltime"):
                if strftime:
                    return time.strftime(strftime, time.localtime(record.wall))
                return f"{wall}, {record.stamp.to_sec():.6f}" if name == "time" and simulated else wall
            values = {
                "severity": NAMES[record.level],
                "message": record.text,
                "logger": record.logger,
                "file": record.path or record.file,
                "line": str(record.line),
                "function": record.function,
                "node": self.node_name,
                "thread": str(threading.get_ident()),
            }
            return values.get(name, token.group(0))

        return _TOKEN.sub(replace, self._format)

    def _file_line(self, record: Record) -> str:
        stamp = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(record.wall))
        text = terminal_text.coloured_lines(record.text)
        return f"[{record.logger}][{_FILE_NAMES[record.level]}] {stamp},{int(record.wall % 1 * 1000):03d}: {text}\n"

    def _write_items(self, items: list[Item], _should_stop: ShouldStop) -> None:
        self._write_file("".join(text for _, text in items))

    def _write_file(self, text: str) -> None:
        with self._lock:
            if self._file is not None:
                self._file.write(text)

    def close(self) -> None:
        """Write the remaining records, for at most a second or two, and close the log file."""
        self.reset_after_fork()
        self.repeats.close()
        self._terminal_thread.close()
        self._file_thread.close()
        # A signal handler may run on top of this thread's own writing, which continues only afterwards.
        if not self._lock.acquire(timeout=0.0 if self._thread_state.writing else 1.0):
            return  # another thread is waiting for the disk
        try:
            if self._file is not None:
                self._file.close()
                self._file = None
        finally:
            self._lock.release()


def _write_line(stream: TextIO, line: str) -> None:
    try:
        stream.write(line)
        stream.flush()
    except RuntimeError:  # in a signal handler, on top of a print() or write() of the program to the same stream
        os.write(stream.fileno(), line.encode(stream.encoding or "utf-8", "replace"))


def default_log_file(node_name: str, environ: Mapping[str, str], special: Mapping[str, str]) -> str:
    """Return the node's log file: ``__log:=``, else ``$ROS_LOG_DIR/<name>.log`` (N14, N30, P38)."""
    if special.get("__log"):
        return special["__log"]
    folder = environ.get("ROS_LOG_DIR") or os.path.join(
        environ.get("ROS_HOME") or os.path.join(os.path.expanduser("~"), ".ros"), "log"
    )
    return os.path.join(folder, node_name.strip("/").replace("/", "_") + ".log")
