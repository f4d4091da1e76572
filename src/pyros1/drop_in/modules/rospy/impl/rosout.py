"""The log: Python's loggers ``rosout`` and below, and the node, which writes their records to the terminal, to its
log file and to /rosout (https://wiki.ros.org/rospy/Overview/Logging).
"""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Callable, Iterator, MutableMapping
from typing import TYPE_CHECKING, Any

from pyros1.drop_in.process import PROCESS
from pyros1.ground.errors import NodeShutdownError
from pyros1.ground.names import parse_arguments
from pyros1.node.log.services import QUEUE_SIZE
from pyros1.node.log.sink import ALL_DESTINATIONS, Destinations, default_log_file
from rospy.exceptions import ROSTimeMovedBackwardsException
from rospy.impl.loggers import logerr

if TYPE_CHECKING:
    from pyros1.node import Node
    from pyros1.node.log.logger import Log

_PYTHON_LEVELS = {1: logging.DEBUG, 2: logging.INFO, 4: logging.WARNING, 8: logging.ERROR, 16: logging.CRITICAL}
_STOCK_LOGGERS = ("rospy", "rospy.internal", "rospy.service", "rospy.tcpros", "rospy.topics")
"""Loggers that exist in stock ROS, too."""
_CONFIG_VARIABLE = "ROS_PYTHON_LOG_CONFIG_FILE"
_LOG_FILE_VARIABLE = "ROS_LOG_FILENAME"
_ROSOUT_ONLY = Destinations(terminal=False, file=False)
_FILE_ONLY = Destinations(terminal=False, rosout=False)


def python_level(level: int) -> int:
    """Convert one of rospy's levels to Python's."""
    return _PYTHON_LEVELS[level]


def ros_level(level: int) -> int:
    """Convert one of Python's levels to rospy's: 1, 2, 4, 8 or 16."""
    return max((ros for ros, python in _PYTHON_LEVELS.items() if python <= level), default=1)


class LoggerLevels(MutableMapping[str, int]):
    """The levels of Python's loggers, as the node's services list and change them."""

    def __getitem__(self, name: str) -> int:
        return ros_level(logging.getLogger(name).getEffectiveLevel())

    def __setitem__(self, name: str, level: int) -> None:
        logging.getLogger(name).setLevel(_PYTHON_LEVELS[level])

    def __delitem__(self, name: str) -> None:
        logging.getLogger(name).setLevel(logging.NOTSET)

    def __iter__(self) -> Iterator[str]:
        loggers = logging.Logger.manager.loggerDict
        return iter([name for name, logger in list(loggers.items()) if isinstance(logger, logging.Logger)])

    def __len__(self) -> int:
        return len(list(iter(self)))


def _log_record(log: Log, record: logging.LogRecord, text: str, destinations: Destinations) -> None:
    log.log_record(
        ros_level(record.levelno),
        text,
        path=record.pathname,
        line=record.lineno,
        function=record.funcName or "",
        name=record.name,
        destinations=destinations,
    )


class RosOutHandler(logging.Handler):
    """Passes the records of the logger ``rosout`` to the node.

    Args:
        node: the node.
        writes_locally: whether the node also writes them to the terminal and its log file.
    """

    def __init__(self, node: Node, writes_locally: bool = True) -> None:
        super().__init__()
        self._log = node.log
        self._writes_locally = writes_locally

    def emit(self, record: logging.LogRecord) -> None:
        """Write one record."""
        text = self.format(record)  # wrong arguments raise an error in the program, as in stock ROS
        destinations = ALL_DESTINATIONS if self._writes_locally else _ROSOUT_ONLY
        try:
            _log_record(self._log, record, text, destinations)
        except Exception:  # noqa: BLE001 - handleError() reports it, as in Python's handlers
            self.handleError(record)


class _FileHandler(logging.Handler):
    """Writes the records of all other loggers to the node's log file."""

    def __init__(self, node: Node) -> None:
        super().__init__(logging.INFO)
        self._log = node.log

    def emit(self, record: logging.LogRecord) -> None:
        if record.name.partition(".")[0] == "rosout":
            return  # RosOutHandler has already written the record
        try:
            _log_record(self._log, record, self.format(record), _FILE_ONLY)
        except Exception:  # noqa: BLE001 - handleError() reports it
            self.handleError(record)


def configure(level: int) -> str:
    """Set the levels of Python's loggers, unless ROS_PYTHON_LOG_CONFIG_FILE names an existing file.

    Args:
        level: rospy's level of the logger ``rosout``.

    Returns:
        The path of that file; empty if there is none.
    """
    for name in _STOCK_LOGGERS:
        logging.getLogger(name)
    path = os.environ.get(_CONFIG_VARIABLE)
    if path and os.path.isfile(path):
        return path
    logging.getLogger().setLevel(logging.INFO)
    logging.getLogger("rosout").setLevel(_PYTHON_LEVELS[level])
    return ""


def _load_config(path: str) -> None:
    """Configure Python's loggers from a file, which may refer to the log file (ROS_LOG_FILENAME)."""
    from logging.config import dictConfig, fileConfig

    os.makedirs(os.path.dirname(os.environ[_LOG_FILE_VARIABLE]) or ".", exist_ok=True)
    if path.endswith((".yaml", ".yml")):
        import yaml

        with open(path, encoding="utf-8") as file:
            settings = yaml.safe_load(file)
        settings.setdefault("version", 1)
        dictConfig(settings)
    else:
        fileConfig(path, disable_existing_loggers=False)


class _OldProgramHints:
    """Returns a hint if a callback's error is typical of a program for an old Python version; each hint only once."""

    def __init__(self) -> None:
        self._shown_hints: set[str] = set()

    def __call__(self, error: BaseException) -> str:
        from pyros1.drop_in.start import pyros1_modules

        hint: str = pyros1_modules.hint_for(error)  # type: ignore[no-untyped-call]  # the module is for any Python
        if not hint or hint in self._shown_hints:
            return ""
        self._shown_hints.add(hint)
        return "\n" + hint


_hints = _OldProgramHints()


def with_error_logging(callback: Callable[[Any], object], original: object) -> Callable[[Any], None]:
    """Return a callback that logs its errors with the logger ``rosout``, whose handlers programs may have added.

    Args:
        callback: called with each message.
        original: the callback that the program passed, for the error message.
    """

    def call(message: Any) -> None:
        try:
            callback(message)
        except Exception as error:
            time_moved_back = isinstance(error, ROSTimeMovedBackwardsException)  # also a kind of ROSInterruptException
            if (
                isinstance(error, (KeyboardInterrupt, NodeShutdownError)) and not time_moved_back
            ) or PROCESS.is_shutdown:
                raise  # the shutdown interrupted a wait; the node handles this
            import traceback

            first_frame = error.__traceback__
            trace = traceback.format_exception(type(error), error, first_frame and (first_frame.tb_next or first_frame))
            logerr("bad callback: %s\n%s%s", original, "".join(trace), _hints(error))

    return call


def connect_loggers(node: Node, argv: list[str], config: str) -> None:
    """Pass the records of Python's loggers to the node.

    Args:
        node: the node.
        argv: the node's command line.
        config: path of a configuration file, which selects the records to show and to write; empty if there is none.
    """
    os.environ[_LOG_FILE_VARIABLE] = default_log_file(node.name, os.environ, parse_arguments(argv).special)
    if config:
        _load_config(config)
    node.log.use_levels(LoggerLevels())
    node.log.explain_with(_hints)
    root, rosout = logging.getLogger(), logging.getLogger("rosout")
    if not config:
        for logger in (root, rosout):
            _remove_terminal_handlers(logger)
        root.addHandler(_FileHandler(node))
    rosout.addHandler(RosOutHandler(node, writes_locally=not config))


def _remove_terminal_handlers(logger: logging.Logger) -> None:
    """Remove handlers that print, such as ``logging.basicConfig``'s: they would print rospy's messages a second time.

    Stock's configuration removes all handlers that exist before the node starts; ours keeps those that write
    elsewhere.
    """
    terminal_streams = (sys.stdout, sys.stderr, sys.__stdout__, sys.__stderr__)
    for handler in [
        candidate for candidate in logger.handlers if getattr(candidate, "stream", None) in terminal_streams
    ]:
        logger.removeHandler(handler)


def list_rosout_topic() -> None:
    """Add /rosout, which the node itself publishes, to the program's list of topics, as in stock ROS."""
    from pyros1.msgs.rosgraph_msgs.msg import Log
    from rospy.topics import Publisher

    Publisher("/rosout", Log, latch=True, queue_size=QUEUE_SIZE)
