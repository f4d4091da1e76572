"""The loggers of a node: ``node.log``.

The module `logging` is not used: importing it takes as long as the rest of a small node, and its levels are different.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Hashable, MutableMapping
from types import CodeType, FrameType

from pyros1.ground import terminal_text
from pyros1.net.rate_limit import MAX_TEXTS
from pyros1.node.checks import check_seconds
from pyros1.node.log.levels import DEBUG, ERROR, FATAL, INFO, LEVEL_NAMES, WARN
from pyros1.node.log.sink import ALL_DESTINATIONS, NO_TERMINAL, Destinations, LogSink, Record

_MAX_SITES = 10_000
"""Maximum number of places in the program for which the time of the last message is kept, for ``throttle`` and
``once``."""


class Log:
    """A logger of a node: ``node.log``.

    Messages are formatted as with C's printf: ``log.info("x is %.3f", x)``. With ``throttle=seconds``, a call logs at
    most one message per that many seconds; with ``once=True``, it logs only the first time it is reached. Signal
    handlers may log as well.
    """

    def __init__(self, sink: LogSink, name: str = "rosout", level: int = INFO) -> None:
        self._sink = sink
        self.name = name
        sink.levels.setdefault(name, level)

    @property
    def level(self) -> int:
        """The minimum level that is logged: 1, 2, 4, 8 or 16."""
        return self._sink.levels[self.name]

    @level.setter
    def level(self, level: int) -> None:
        if level not in LEVEL_NAMES:
            raise ValueError(f"a log level must be one of {', '.join(map(str, LEVEL_NAMES))}, not {level!r:.80}")
        self._sink.levels[self.name] = level

    def named(self, name: str) -> Log:
        """Return the child logger ``<name of this logger>.<name>``, which has its own level."""
        return Log(self._sink, f"{self.name}.{name}", self.level)

    def debug(self, text: object, *args: object, throttle: float | None = None, once: bool = False) -> None:
        """Log details for debugging."""
        self._log(DEBUG, text, args, throttle, once)

    def info(self, text: object, *args: object, throttle: float | None = None, once: bool = False) -> None:
        """Log information for the user."""
        self._log(INFO, text, args, throttle, once)

    def note(self, text: object) -> None:
        """Log information to the log file and /rosout only, for programs that display it in their own way."""
        if self.level <= INFO:
            frame = sys._getframe(1)
            self._emit(INFO, str(text), frame.f_code, frame.f_lineno, _is_user_code(frame), to_terminal=False)

    def warn(self, text: object, *args: object, throttle: float | None = None, once: bool = False) -> None:
        """Log something that may be wrong."""
        self._log(WARN, text, args, throttle, once)

    def error(self, text: object, *args: object, throttle: float | None = None, once: bool = False) -> None:
        """Log an error."""
        self._log(ERROR, text, args, throttle, once)

    warning = warn
    """Log something that may be wrong; an alias of `warn`, with the name in Python's logging module."""

    def fatal(self, text: object, *args: object, throttle: float | None = None, once: bool = False) -> None:
        """Log an error after which the node cannot continue."""
        self._log(FATAL, text, args, throttle, once)

    def exception(self, text: object, *args: object, error: BaseException | None = None) -> None:
        """Log an error with its traceback.

        Args:
            text: the message.
            args: arguments of the message, as for the other levels. If the only argument is an exception and the
                message has no placeholder, it is used as ``error``.
            error: the exception; None for the one being handled.
        """
        if error is None:
            error = sys.exc_info()[1]
            if len(args) == 1 and isinstance(args[0], BaseException) and "%" not in str(text):
                error, args = args[0], ()
        details = "" if error is None else "\n" + format_traceback(error)
        if error is not None and self._sink.explain is not None:
            details += self._sink.explain(error)
        self._log(ERROR, terminal_text.lines(_format(text, args) + details), (), None, False)

    def peer_event(
        self, level: int, text: str, *args: object, max_texts: int = MAX_TEXTS, link: Hashable = None
    ) -> None:
        """Log an event caused by another process. Repeated messages are counted: ``... (repeated 37 times)``.

        Args:
            level: 1, 2, 4, 8 or 16.
            text: the message, with %s in place of the arguments.
            args: arguments of the message, each printed on one line without control characters.
            max_texts: maximum number of different messages per period from the calling place in the program.
            link: the link that the message is about, if the limit applies to each link separately.
        """
        sink = self._sink
        if level < sink.levels[self.name]:
            return
        frame = sys._getframe(1)
        code, line = frame.f_code, frame.f_lineno

        def emit(message: str) -> None:
            self._emit(level, message, code, line, False)

        sink.reset_after_fork()
        shown_text = text % tuple(map(terminal_text.one_line, args)) if args else text
        sink.repeats.log((code.co_filename, line, link), shown_text, emit, max_texts)

    def internal_error(self, error: BaseException) -> None:
        """Log an internal error of pyros1."""
        self.peer_event(ERROR, terminal_text.lines(f"internal error (please report it)\n{format_traceback(error)}"))

    def log_record(
        self,
        level: int,
        text: str,
        *,
        path: str,
        line: int,
        function: str,
        name: str | None = None,
        destinations: Destinations = ALL_DESTINATIONS,
    ) -> None:
        """Log a message that another logging system, such as Python's, has already filtered and formatted.

        Args:
            level: 1, 2, 4, 8 or 16.
            text: the message.
            path, line, function: where the message was logged.
            name: the logger's name; None for the name of this logger.
            destinations: where to write the message.
        """
        sink = self._sink
        stamp, simulated = sink.now()
        file = os.path.basename(path)
        record = Record(level, text, name or self.name, file, line, function, time.time(), stamp, path)
        sink.emit(record, simulated, destinations)

    def use_levels(self, levels: MutableMapping[str, int]) -> None:
        """Keep the levels of the node's loggers in ``levels`` from now on.

        Args:
            levels: logger name -> minimum level that is logged (1, 2, 4, 8 or 16). The services ~get_loggers and
                ~set_logger_level read and change this object.
        """
        self._sink.levels = levels

    def explain_with(self, explain: Callable[[BaseException], str]) -> None:
        """Add an explanation to the errors that `exception` logs.

        Args:
            explain: returns the explanation to append to the traceback; empty for none.
        """
        self._sink.explain = explain

    def _log(self, level: int, text: object, args: tuple[object, ...], throttle: float | None, once: bool) -> None:
        sink = self._sink
        if level < sink.levels[self.name]:
            return
        frame = sys._getframe(2)
        code, line = frame.f_code, frame.f_lineno
        if throttle is not None or once:
            if throttle is not None:
                throttle = throttle.to_sec() if hasattr(throttle, "to_sec") else throttle  # for example a Duration
                check_seconds(throttle, "throttle")
            now = sink.now()[0].to_sec()
            if not self._admit_message((code.co_filename, line), now, throttle, once):
                return
        self._emit(level, _format(text, args), code, line, _is_user_code(frame))

    def _emit(
        self, level: int, message: str, code: CodeType, line: int, is_user_code: bool, to_terminal: bool = True
    ) -> None:
        stamp, simulated = self._sink.now()
        file = os.path.basename(code.co_filename)
        record = Record(level, message, self.name, file, line, code.co_name, time.time(), stamp, code.co_filename)
        self._sink.emit(record, simulated, ALL_DESTINATIONS if to_terminal else NO_TERMINAL, is_user_code)

    def _admit_message(self, site: tuple[str, int], now: float, throttle: float | None, once: bool) -> bool:
        """Return whether a message from a place in the program is to be logged now; if so, record the time."""
        last_times = self._sink.last_times
        last_time = last_times.get(site)
        if last_time is not None and (once or (throttle is not None and 0 <= now - last_time < throttle)):
            return False
        if len(last_times) > _MAX_SITES:
            last_times.clear()
        last_times[site] = now
        return True


def _is_user_code(frame: FrameType) -> bool:
    return not str(frame.f_globals.get("__name__")).startswith("pyros1.")


def _format(text: object, args: tuple[object, ...]) -> str:
    """Return the formatted message, with a note if the arguments do not match the placeholders."""
    message = str(text)
    if not args:
        return message
    try:
        return message % args
    except (TypeError, ValueError) as error:
        return f"{message} {args!r} (bad log arguments: {error})"


def format_traceback(error: BaseException) -> str:
    """Return an exception's traceback as a string."""
    try:
        from traceback import format_exception  # noqa: PLC0415 - slow to import

        return "".join(format_exception(type(error), error, error.__traceback__)).rstrip()
    except Exception:  # noqa: BLE001 - the import fails if there are too many open files
        return f"{type(error).__name__}: {error}"
