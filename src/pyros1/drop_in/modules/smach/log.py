"""Log functions of state machines; they print to stdout by default."""

from __future__ import annotations

from collections.abc import Callable

LogFunction = Callable[[str], object]


def _make_printer(level: str) -> LogFunction:
    return lambda msg: print(f"[ {level} ] : {msg}")


_LOG_FUNCTIONS: dict[str, LogFunction] = {level: _make_printer(level) for level in ("INFO", "WARN", "DEBUG", "ERROR")}


def loginfo(msg: str) -> None:
    """Log an informational message."""
    _LOG_FUNCTIONS["INFO"](msg)


def logwarn(msg: str) -> None:
    """Log a warning."""
    _LOG_FUNCTIONS["WARN"](msg)


def logdebug(msg: str) -> None:
    """Log a debug message."""
    _LOG_FUNCTIONS["DEBUG"](msg)


def logerr(msg: str) -> None:
    """Log an error."""
    _LOG_FUNCTIONS["ERROR"](msg)


def set_loggers(info: LogFunction, warn: LogFunction, debug: LogFunction, error: LogFunction) -> None:
    """Replace the log functions; ``import smach_ros`` sets rospy's."""
    _LOG_FUNCTIONS.update(INFO=info, WARN=warn, DEBUG=debug, ERROR=error)


__all__ = ["logdebug", "logerr", "loginfo", "logwarn", "set_loggers"]
