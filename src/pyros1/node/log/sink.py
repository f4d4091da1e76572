"""Writes a node's log messages to the terminal in rosconsole's format, to the log file and to /rosout.

Messages logged by the program are written before the call returns, so that they are visible even if the program crashes
in the next line. Messages logged by pyros1 itself are written by separate threads: a paused terminal, a full pipe or a
slow disk must not prevent the node from registering, receiving and serving. All threads except the loop wait briefly
until earlier messages are written, so that the lines are normally in order.

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
from pyros1.node.log.levels import DEBUG, ERROR, FATAL, INFO, LEVEL_NAMES, WARN

DEFAULT_FORMAT = "[${severity}] [${time}]: ${message}"
MAX_FILE_SIZE = 50_000_000
MAX_BACKUPS = 4
_COLOURS = {DEBUG: "\x1b[32m", WARN: "\x1b[33m", ERROR: "\x1b[31m", FATAL: "\x1b[31m"}
_FORMAT_TOKEN = re.compile(r"\$\{(\w+)(?::([^}]*))?\}")
_FILE_LEVELS = {**LEVEL_NAMES, WARN: "WARNING", FATAL: "CRITICAL"}  # stock's log files use Python's level names
_MAX_PENDING = 100


class Record(NamedTuple):
    """A log message.

    Attributes:
        level: 1, 2, 4, 8 or 16, as in rosgraph_msgs/Log.
        text: the formatted message.
        logger: name of the logger, ``rosout`` or a child of it.
        file, line, function: where the message was logged; the file name does not include its folder.
        wall_time: seconds since the epoch.
        stamp: the node's time, which may be simulated.
        path: the file's full path.
    """

    level: int
    text: str
    logger: str
    file: str
    line: int
    function: str
    wall_time: float
    stamp: Time
    path: str = ""


class Destinations(NamedTuple):
    """The destinations that a record is written to."""

    terminal: bool = True
    file: bool = True
    rosout: bool = True


ALL_DESTINATIONS = Destinations()
NO_TERMINAL = Destinations(terminal=False)


class _ThreadState(threading.local):
    """The state of a thread that writes to a sink.

    Attributes:
        is_writing: whether the thread is writing a record.
        pending_records: the records to write, each with the other arguments of `LogSink.emit`.
    """

    def __init__(self) -> None:
        self.is_writing = False
        self.pending_records: deque[tuple[Record, bool, Destinations, bool]] = deque()


class LogSink:
    """The sink of a node's log messages, shared by all its loggers; writes to the terminal, the file and /rosout.

    Args:
        node_name: the node's full name.
        environ: environment variables; ROSCONSOLE_FORMAT is used.
        file_path: path of the log file, which is created with its folder when the first line is written; None for no
            file.
        now: returns the node's time, and whether it is simulated.
        schedule: ``schedule(seconds, function, argument)`` calls a function after a delay. If this argument is
            None, the counts of repeated messages are written only when the sink is closed.
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
        self.last_times: dict[tuple[str, int], float] = {}
        self.publish: Callable[[Record], None] | None = None
        self._schedule = schedule or (lambda *_: None)
        self._template = environ.get("ROSCONSOLE_FORMAT") or DEFAULT_FORMAT
        self._file = LogFile(file_path, MAX_FILE_SIZE, MAX_BACKUPS) if file_path else None
        self._thread_state = _ThreadState()
        self._inherited_file: LogFile | None = None  # opened by the parent process
        self._make_locks_and_writers()

    def _make_locks_and_writers(self) -> None:
        self._lock = threading.Lock()
        self.repeats = RepeatCounter(self._schedule)
        self._terminal_writer = BackgroundWriter(f"{self.node_name}:log", write_to_terminal)
        self._file_writer = BackgroundWriter(f"{self.node_name}:log file", self._write_items)
        self._pid = os.getpid()

    def reset_after_fork(self) -> None:
        """Prepare for use in a forked process, in which locks may be held by threads that no longer exist."""
        if os.getpid() != self._pid:
            if self._file is not None:
                # The parent's file is kept, since closing it could block on its lock.
                self._inherited_file, self._file = self._file, self._file.reopened()
            self._make_locks_and_writers()

    def emit(
        self, record: Record, simulated: bool, destinations: Destinations = ALL_DESTINATIONS, by_program: bool = True
    ) -> None:
        """Write a record. An error at a destination (a full disk, a closed pipe) does not stop the node.

        If a signal handler interrupts this method and logs a record, that record is written when this method continues.

        Args:
            record: the log message.
            simulated: whether the record's stamp is simulated time.
            destinations: where to write the record.
            by_program: whether the user's program, not pyros1, has logged the record; if so, this method waits until
                the record is written.
        """
        self.reset_after_fork()
        state = self._thread_state
        state.pending_records.append((record, simulated, destinations, by_program))
        if state.is_writing:
            return
        for _ in range(_MAX_PENDING):  # limited, since writing a record may log new ones
            if not state.pending_records:
                return
            try:
                state.is_writing = True
                self._write(*state.pending_records.popleft())
            finally:
                state.is_writing = False  # cleared before the loop looks for records of a signal handler

    def _write(self, record: Record, simulated: bool, destinations: Destinations, by_program: bool) -> None:
        is_on_loop = isinstance(threading.current_thread(), LoopThread)
        may_wait = by_program and not is_on_loop
        if may_wait:
            self._flush()  # write pyros1's own earlier messages first
        if destinations.terminal:
            self._write_to_terminal(record, simulated, may_wait)
        if destinations.file and self._file is not None:
            line = self._format_file_line(record)
            if may_wait:
                self._write_file(line)
            else:
                self._file_writer.write("", line)
        if destinations.rosout and self.publish is not None:
            try:
                self.publish(record)
            except Exception as error:  # noqa: BLE001 - for example if there are too many open files
                self._terminal_writer.write(
                    "stderr", terminal_text.lines(f"WARNING: cannot publish a log message on /rosout: {error}\n")
                )
        if not is_on_loop:
            self._flush()

    def _flush(self) -> None:
        self._terminal_writer.flush()
        self._file_writer.flush()

    def _write_to_terminal(self, record: Record, simulated: bool, may_wait: bool) -> None:
        stream_name = "stdout" if record.level <= INFO else "stderr"
        stream = getattr(sys, stream_name)
        text = terminal_text.coloured_lines(self.format(record, simulated)) + "\n"
        with contextlib.suppress(OSError, ValueError, AttributeError):
            colour = _COLOURS.get(record.level) if stream.isatty() else None
            if colour:
                text = f"{colour}{text[:-1]}\x1b[0m\n"
            if may_wait:
                _write_line(stream, text)
            else:
                self._terminal_writer.write(stream_name, text)

    def format(self, record: Record, simulated: bool) -> str:
        """Return the record formatted according to ROSCONSOLE_FORMAT (N31)."""
        wall_text = f"{record.wall_time:.6f}"

        def replace(token: re.Match[str]) -> str:
            name, time_format = token.group(1), token.group(2)
            if name in ("time", "walltime"):
                if time_format:
                    return time.strftime(time_format, time.localtime(record.wall_time))
                return f"{wall_text}, {record.stamp.to_sec():.6f}" if name == "time" and simulated else wall_text
            values = {
                "severity": LEVEL_NAMES[record.level],
                "message": record.text,
                "logger": record.logger,
                "file": record.path or record.file,
                "line": str(record.line),
                "function": record.function,
                "node": self.node_name,
                "thread": str(threading.get_ident()),
            }
            return values.get(name, token.group(0))

        return _FORMAT_TOKEN.sub(replace, self._template)

    def _format_file_line(self, record: Record) -> str:
        stamp = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(record.wall_time))
        text = terminal_text.coloured_lines(record.text)
        return (
            f"[{record.logger}][{_FILE_LEVELS[record.level]}] {stamp},{int(record.wall_time % 1 * 1000):03d}: {text}\n"
        )

    def _write_items(self, items: list[Item], _should_stop: ShouldStop) -> None:
        self._write_file("".join(text for _, text in items))

    def _write_file(self, text: str) -> None:
        with self._lock:
            if self._file is not None:
                self._file.write(text)

    def close(self) -> None:
        """Write the remaining records, taking at most a second or two, and close the log file."""
        self.reset_after_fork()
        self.repeats.close()
        self._terminal_writer.close()
        self._file_writer.close()
        # A signal handler that has interrupted a write in this thread must not wait for the lock, which is
        # released only when that write continues.
        if not self._lock.acquire(timeout=0.0 if self._thread_state.is_writing else 1.0):
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
    except RuntimeError:  # in a signal handler that has interrupted a print() or write() to the same stream
        os.write(stream.fileno(), line.encode(stream.encoding or "utf-8", "replace"))


def default_log_file(node_name: str, environ: Mapping[str, str], special: Mapping[str, str]) -> str:
    """Return the path of a node's log file: ``__log:=``, else ``$ROS_LOG_DIR/<name>.log`` (N14, N30, P38)."""
    if special.get("__log"):
        return special["__log"]
    folder = environ.get("ROS_LOG_DIR") or os.path.join(
        environ.get("ROS_HOME") or os.path.join(os.path.expanduser("~"), ".ros"), "log"
    )
    return os.path.join(folder, node_name.strip("/").replace("/", "_") + ".log")
