"""Log functions of state machines; they print to stdout by default."""

from __future__ import annotations

from collections.abc import Callable

Log = Callable[[str], object]


def _printing(level: str) -> Log:
    return lambda msg: print(f"[ {level} ] : {msg}")


_LOGS: dict[str, Log] = {level: _printing(level) for level in ("INFO", "WARN", "DEBUG", "ERROR")}


def loginfo(msg: str) -> None:
    """Log an informational message."""
    _LOGS["INFO"](msg)


def logwarn(msg: str) -> None:
    """Log a warning."""
    _LOGS["WARN"](msg)


def logdebug(msg: str) -> None:
    """Log a debug message."""
    _LOGS["DEBUG"](msg)


def logerr(msg: str) -> None:
    """Log an error."""
    _LOGS["ERROR"](msg)


def set_loggers(info: Log, warn: Log, debug: Log, error: Log) -> None:
    """Replace the log functions; ``import smach_ros`` sets those of rospy."""
    _LOGS.update(INFO=info, WARN=warn, DEBUG=debug, ERROR=error)


__all__ = ["logdebug", "logerr", "loginfo", "logwarn", "set_loggers"]
