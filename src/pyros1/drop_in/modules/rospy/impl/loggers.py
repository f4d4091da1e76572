"""The functions ``loginfo`` and so on. Records go through Python's logger ``rosout``; see `rospy.impl.rosout`."""

from __future__ import annotations

import sys
from collections.abc import Callable
from types import FrameType
from typing import Any

_MAX_CALL_SITES = 10_000
_DEBUG, _INFO, _WARN, _ERROR, _CRITICAL = 10, 20, 30, 40, 50

CallSite = tuple[str, int, int]


def _call_site(frame: FrameType) -> CallSite:
    """Return a value that identifies the call in the program's source."""
    return frame.f_code.co_filename, frame.f_lineno, frame.f_lasti


def _remember(table: dict[Any, Any], key: Any, value: Any) -> None:
    if len(table) >= _MAX_CALL_SITES:
        table.clear()
    table[key] = value


class LoggingThrottle:
    """Rate limit for call sites: called with (call site, period in seconds), returns whether the site may log again."""

    last_logging_time_table: dict[Any, float] = {}

    def __call__(self, caller_id: Any, period: float) -> bool:
        from rospy.rostime import get_time

        now, last = get_time(), self.last_logging_time_table.get(caller_id)
        if last is not None and 0 <= now - last < period:
            return False
        _remember(self.last_logging_time_table, caller_id, now)
        return True


class LoggingIdentical:
    """Filter of repeated messages: called with (call site, message), returns whether the site's message has changed."""

    last_logging_msg_table: dict[Any, str] = {}

    def __call__(self, caller_id: Any, msg: Any) -> bool:
        text = str(msg)
        if self.last_logging_msg_table.get(caller_id) == text:
            return False
        _remember(self.last_logging_msg_table, caller_id, text)
        return True


class LoggingOnce:
    """Filter of repeated calls: called with a call site, returns whether the site logs for the first time."""

    called_caller_ids: set[Any] = set()

    def __call__(self, caller_id: Any) -> bool:
        if caller_id in self.called_caller_ids:
            return False
        self.called_caller_ids.add(caller_id)
        return True


_may_log_again, _is_new_text, _is_first = LoggingThrottle(), LoggingIdentical(), LoggingOnce()


def _emit(name: str, level: int, frame: FrameType, msg: Any, args: tuple[Any, ...], kwargs: dict[str, Any]) -> None:
    import logging

    logger_name = kwargs.pop("logger_name", None)
    logger = logging.getLogger(f"{name}.{logger_name}" if logger_name else name)
    if not logger.isEnabledFor(level):
        return
    exc_info = kwargs.pop("exc_info", None)
    if isinstance(exc_info, BaseException):
        exc_info = (type(exc_info), exc_info, exc_info.__traceback__)
    elif exc_info and not isinstance(exc_info, tuple):
        exc_info = sys.exc_info()
    extra = kwargs.pop("extra", None)
    stack = "".join(_stack(frame)) if kwargs.pop("stack_info", False) else None
    kwargs.pop("stacklevel", None)
    if kwargs:
        raise TypeError(f"a log function got an unexpected keyword argument {next(iter(kwargs))!r}")
    code = frame.f_code
    function = code.co_name
    if "self" in code.co_varnames and "self" in frame.f_locals:
        function = f"{type(frame.f_locals['self']).__name__}.{function}"
    record = logger.makeRecord(
        logger.name, level, code.co_filename, frame.f_lineno, msg, args, exc_info, function, extra, stack
    )
    logger.handle(record)


def _stack(frame: FrameType) -> list[str]:
    import traceback

    return ["Stack (most recent call last):\n", *traceback.format_stack(frame)]


def _make_log_functions(level: int, base_name: str, name: str = "rosout") -> list[Callable[..., None]]:
    def log(msg: Any, *args: Any, **kwargs: Any) -> None:
        """Log a message, with ``args`` filled in. ``logger_name`` is the name of a logger below rosout."""
        _emit(name, level, sys._getframe(1), msg, args, kwargs)

    def throttle(period: float, msg: Any, *args: Any, **kwargs: Any) -> None:
        """Log a message. This line of the program logs at most one message in ``period`` seconds."""
        frame = sys._getframe(1)
        if _may_log_again(_call_site(frame), period):
            _emit(name, level, frame, msg, args, kwargs)

    def identical(period: float, msg: Any, *args: Any, **kwargs: Any) -> None:
        """Log a message. This line of the program logs the same message again only after ``period`` seconds."""
        frame = sys._getframe(1)
        call_site = _call_site(frame)
        if _is_new_text(call_site, msg):  # compares the format strings, without arguments, like stock
            _may_log_again(call_site, 0)
        elif not _may_log_again(call_site, period):
            return
        _emit(name, level, frame, msg, args, kwargs)

    def once(msg: Any, *args: Any, **kwargs: Any) -> None:
        """Log a message. This line of the program logs only the first time that it is executed."""
        frame = sys._getframe(1)
        if _is_first(_call_site(frame)):
            _emit(name, level, frame, msg, args, kwargs)

    functions: list[Callable[..., None]] = [log, throttle, identical, once]
    for function, suffix in zip(functions, ("", "_throttle", "_throttle_identical", "_once"), strict=True):
        function.__name__ = function.__qualname__ = base_name + suffix
    return functions


logdebug, logdebug_throttle, logdebug_throttle_identical, logdebug_once = _make_log_functions(_DEBUG, "logdebug")
loginfo, loginfo_throttle, loginfo_throttle_identical, loginfo_once = _make_log_functions(_INFO, "loginfo")
logwarn, logwarn_throttle, logwarn_throttle_identical, logwarn_once = _make_log_functions(_WARN, "logwarn")
logerr, logerr_throttle, logerr_throttle_identical, logerr_once = _make_log_functions(_ERROR, "logerr")
logfatal, logfatal_throttle, logfatal_throttle_identical, logfatal_once = _make_log_functions(_CRITICAL, "logfatal")
logout = loginfo
logerror = logerr
rospydebug, rospyinfo, rospywarn, rospyerr = (
    _make_log_functions(level, word, "rospy.internal")[0]
    for level, word in ((_DEBUG, "debug"), (_INFO, "info"), (_WARN, "warning"), (_ERROR, "error"))
)
_LEVELS = {"debug": _DEBUG, "info": _INFO, "warning": _WARN, "warn": _WARN, "error": _ERROR, "critical": _CRITICAL}


def _base_logger(
    msg: Any,
    args: tuple[Any, ...],
    kwargs: dict[str, Any],
    throttle: float | None = None,
    throttle_identical: bool = False,
    level: str = "info",
    once: bool = False,
) -> None:
    """Log a message; in stock ROS, `loginfo` and the like call this function. ``level`` is the name of the level."""
    frame = sys._getframe(1)
    call_site = _call_site(frame.f_back or frame)
    if once:
        must_log = _is_first(call_site)
    elif throttle_identical:
        may_log = throttle is not None and _may_log_again(call_site, throttle)
        must_log = _is_new_text(call_site, msg) or may_log
    else:
        must_log = not throttle or _may_log_again(call_site, throttle)
    if must_log:
        _emit("rosout", _LEVELS[level], frame, msg, args, kwargs)
