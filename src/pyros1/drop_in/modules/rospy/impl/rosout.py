"""The log: Python's loggers ``rosout`` and below, and the node, which writes what they take to the terminal, to its
file and to /rosout (https://wiki.ros.org/rospy/Overview/Logging).
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

_PYTHON = {1: logging.DEBUG, 2: logging.INFO, 4: logging.WARNING, 8: logging.ERROR, 16: logging.CRITICAL}
_STOCK = ("rospy", "rospy.internal", "rospy.service", "rospy.tcpros", "rospy.topics")
"""Loggers that stock has as well."""
_CONFIG = "ROS_PYTHON_LOG_CONFIG_FILE"
_LOG_FILE = "ROS_LOG_FILENAME"
_PUBLISHED = Destinations(terminal=False, file=False)
_FILED = Destinations(terminal=False, rosout=False)


def python_level(level: int) -> int:
    """Return Python's level for one of rospy's."""
    return _PYTHON[level]


def ros_level(level: int) -> int:
    """Return rospy's level, 1, 2, 4, 8 or 16, for one of Python's."""
    return max((ros for ros, python in _PYTHON.items() if python <= level), default=1)


class Levels(MutableMapping[str, int]):
    """The levels of Python's loggers, as the node's services list and change them."""

    def __getitem__(self, name: str) -> int:
        return ros_level(logging.getLogger(name).getEffectiveLevel())

    def __setitem__(self, name: str, level: int) -> None:
        logging.getLogger(name).setLevel(_PYTHON[level])

    def __delitem__(self, name: str) -> None:
        logging.getLogger(name).setLevel(logging.NOTSET)

    def __iter__(self) -> Iterator[str]:
        loggers = logging.Logger.manager.loggerDict
        return iter([name for name, logger in list(loggers.items()) if isinstance(logger, logging.Logger)])

    def __len__(self) -> int:
        return len(list(iter(self)))


def _pass_on(log: Log, record: logging.LogRecord, text: str, destinations: Destinations) -> None:
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
    """Gives the records of the logger ``rosout`` to the node.

    Args:
        node: the node.
        shows: whether it also writes them to the terminal and the file.
    """

    def __init__(self, node: Node, shows: bool = True) -> None:
        super().__init__()
        self._log = node.log
        self._shows = shows

    def emit(self, record: logging.LogRecord) -> None:
        """Write one record."""
        text = self.format(record)  # arguments that do not fit raise in the program, as in stock
        destinations = ALL_DESTINATIONS if self._shows else _PUBLISHED
        try:
            _pass_on(self._log, record, text, destinations)
        except Exception:  # noqa: BLE001 - like Python's handlers
            self.handleError(record)


class _FileHandler(logging.Handler):
    """Writes the records of all other loggers to the node's log file."""

    def __init__(self, node: Node) -> None:
        super().__init__(logging.INFO)
        self._log = node.log

    def emit(self, record: logging.LogRecord) -> None:
        if record.name.partition(".")[0] == "rosout":
            return  # it has been written
        try:
            _pass_on(self._log, record, self.format(record), _FILED)
        except Exception:  # noqa: BLE001 - as above
            self.handleError(record)


def configure(level: int) -> str:
    """Set the levels of Python's loggers, unless there is the file that ROS_PYTHON_LOG_CONFIG_FILE names.

    Args:
        level: rospy's level of the logger ``rosout``.

    Returns:
        The path of that file; empty: there is none.
    """
    for name in _STOCK:
        logging.getLogger(name)
    path = os.environ.get(_CONFIG)
    if path and os.path.isfile(path):
        return path
    logging.getLogger().setLevel(logging.INFO)
    logging.getLogger("rosout").setLevel(_PYTHON[level])
    return ""


def _load(path: str) -> None:
    """Configure Python's loggers from a file. It may ask for the name of the log file (ROS_LOG_FILENAME)."""
    from logging.config import dictConfig, fileConfig

    os.makedirs(os.path.dirname(os.environ[_LOG_FILE]) or ".", exist_ok=True)
    if path.endswith((".yaml", ".yml")):
        import yaml

        with open(path, encoding="utf-8") as file:
            settings = yaml.safe_load(file)
        settings.setdefault("version", 1)
        dictConfig(settings)
    else:
        fileConfig(path, disable_existing_loggers=False)


class _Words:
    """Prints hints, each only once, about errors in callbacks of programs for old Pythons."""

    def __init__(self) -> None:
        self._said: set[str] = set()

    def __call__(self, error: BaseException) -> str:
        from pyros1.drop_in.start import pyros1_modules

        word: str = pyros1_modules.reason_for(error)  # type: ignore[no-untyped-call]  # it is for any Python
        if not word or word in self._said:
            return ""
        self._said.add(word)
        return "\n" + word


_words = _Words()


def guarded(callback: Callable[[Any], object], shown: object) -> Callable[[Any], None]:
    """Return a callback whose errors the logger ``rosout`` tells, so that handlers that programs add to it get them.

    Args:
        callback: called with each message.
        shown: what the program gave as its callback.
    """

    def call(message: Any) -> None:
        try:
            callback(message)
        except Exception as error:
            moved = isinstance(error, ROSTimeMovedBackwardsException)  # also a kind of ROSInterruptException
            if (isinstance(error, (KeyboardInterrupt, NodeShutdownError)) and not moved) or PROCESS.is_shutdown:
                raise  # the shutdown interrupted a wait, which the node handles
            import traceback

            place = error.__traceback__
            trace = traceback.format_exception(type(error), error, place and (place.tb_next or place))
            logerr("bad callback: %s\n%s%s", shown, "".join(trace), _words(error))

    return call


def connect(node: Node, argv: list[str], config: str) -> None:
    """Give the records of Python's loggers to the node.

    Args:
        node: the node.
        argv: its command line.
        config: path of a configuration file, which says what is shown and written; empty: there is none.
    """
    os.environ[_LOG_FILE] = default_log_file(node.name, os.environ, parse_arguments(argv).special)
    if config:
        _load(config)
    node.log.use_levels(Levels())
    node.log.explain_with(_words)
    root, rosout = logging.getLogger(), logging.getLogger("rosout")
    if not config:
        for logger in (root, rosout):
            _leave_terminal(logger)
        root.addHandler(_FileHandler(node))
    rosout.addHandler(RosOutHandler(node, shows=not config))


def _leave_terminal(logger: logging.Logger) -> None:
    """Remove handlers that print, such as that of ``logging.basicConfig``: rospy's messages would be printed twice.

    Stock's configuration removes all handlers that exist before the node starts; ours keeps those that write
    elsewhere.
    """
    terminal = (sys.stdout, sys.stderr, sys.__stdout__, sys.__stderr__)
    for handler in [each for each in logger.handlers if getattr(each, "stream", None) in terminal]:
        logger.removeHandler(handler)


def show_topic() -> None:
    """List /rosout, which the node publishes, with the program's topics, as stock does."""
    from pyros1.msgs.rosgraph_msgs.msg import Log
    from rospy.topics import Publisher

    Publisher("/rosout", Log, latch=True, queue_size=QUEUE_SIZE)
