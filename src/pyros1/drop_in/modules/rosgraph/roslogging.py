"""Log files of programs without a node, such as tools (https://wiki.ros.org/rospy/Overview/Logging)."""

from __future__ import annotations

import logging
import os
import sys
import time
from collections.abc import Mapping
from typing import Any

from rospkg.environment import ROS_LOG_DIR, get_log_dir

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.drop_in.process import PROCESS

__getattr__ = module_getattr(__name__)

_SEVERITY_NAMES = {"WARNING": "WARN", "CRITICAL": "FATAL"}
_COLORS = {"DEBUG": "\033[32m", "WARN": "\033[33m", "ERROR": "\033[31m", "FATAL": "\033[31m"}


class LoggingException(Exception):
    """Logging cannot be set up."""


def makedirs_with_parent_perms(p: str) -> None:
    """Create a folder and its parents, with the permissions and owner of the nearest one that exists."""
    path = os.path.abspath(p)
    if os.path.exists(path):
        return
    parent = os.path.dirname(path)
    makedirs_with_parent_perms(parent)
    parent_status = os.stat(parent)
    os.mkdir(path)
    own_status = os.stat(path)
    if (own_status.st_uid, own_status.st_gid) != (parent_status.st_uid, parent_status.st_gid):
        os.chown(path, parent_status.st_uid, parent_status.st_gid)
    if own_status.st_mode != parent_status.st_mode:
        os.chmod(path, parent_status.st_mode & 0o7777)


def renew_latest_logdir(logfile_dir: str) -> bool:
    """Make the link ``latest`` next to a folder point to the folder; return False if ``latest`` is not a link.

    Raises:
        OSError: the link cannot be created.
    """
    link = os.path.join(os.path.dirname(logfile_dir), "latest")
    if os.path.lexists(link):
        if not os.path.islink(link):
            return False
        os.remove(link)
    os.symlink(logfile_dir, link)
    return True


def configure_logging(
    logname: str, level: int = logging.INFO, filename: str | None = None, env: Mapping[str, str] | None = None
) -> str | None:
    """Write the messages of Python's logging to a file.

    If ROS_PYTHON_LOG_CONFIG_FILE is set, that .conf file is the configuration; otherwise, messages of at least
    ``level`` go into the file.

    Args:
        logname: name of the program; an empty name stands for "unknown".
        level: log level.
        filename: name of the file in the log folder; None for a name made of ``logname`` and the process ID.
        env: environment variables for the folder; None for this process's.

    Returns:
        The path of the file; None, with a message on stderr, if the folder cannot be created.

    Raises:
        LoggingException: the folder's path is a file.
    """
    folder = get_log_dir(os.environ if env is None else env)
    path = os.path.join(folder, filename or f"{logname or 'unknown'}-{os.getpid()}.log")
    log_folder = os.path.dirname(path)
    if os.path.isfile(log_folder):
        raise LoggingException(f"Cannot save log files: file [{log_folder}] is in the way")
    try:
        makedirs_with_parent_perms(log_folder)
    except OSError:
        sys.stderr.write(
            f"WARNING: cannot create log directory [{log_folder}]. Please set ROS_LOG_DIR to a writable location.\n"
        )
        return None
    os.environ["ROS_LOG_FILENAME"] = path
    config = os.environ.get("ROS_PYTHON_LOG_CONFIG_FILE", "")
    if config and os.path.isfile(config):
        from logging.config import fileConfig

        fileConfig(config, disable_existing_loggers=False)
        return path
    from logging.handlers import RotatingFileHandler

    handler = RotatingFileHandler(path, maxBytes=50_000_000, backupCount=4, delay=True)
    handler.setLevel(logging.DEBUG)
    handler.setFormatter(logging.Formatter("[%(name)s][%(levelname)s] %(asctime)s: %(message)s"))
    root = logging.getLogger()
    # Remove the handler added by an earlier call.
    for old_handler in [
        root_handler for root_handler in root.handlers if isinstance(root_handler, RotatingFileHandler)
    ]:
        root.removeHandler(old_handler)
        old_handler.close()
    root.addHandler(handler)
    root.setLevel(level)
    return path


class RospyLogger(logging.Logger):
    """Logger that attributes messages to the program's line rather than to a line in rospy's log functions."""

    def findCaller(self, *args: Any, **kwargs: Any) -> Any:
        """Return path, line, function and stack of the line that logs; arguments as in Python's logging."""
        path, line, name, stack = super().findCaller(*args, **kwargs)
        frame: Any = sys._getframe(1)
        while frame is not None and _is_logging_code(frame.f_code.co_filename):
            frame = frame.f_back
        if frame is None:
            return path, line, name, stack
        return frame.f_code.co_filename, frame.f_lineno, frame.f_code.co_name, stack


def _is_logging_code(path: str) -> bool:
    """Return whether a source file is part of Python's logging, or contains rospy's log functions."""
    return path == logging.__file__ or path.endswith(os.path.join("rospy", "impl", "loggers.py"))


class RosStreamHandler(logging.Handler):
    """Handler that writes messages in the form of ``ROSCONSOLE_FORMAT``, errors and warnings to stderr.

    Args:
        colorize: whether lines are coloured on a terminal.
        stdout, stderr: text files; None for the process's.
    """

    def __init__(self, colorize: bool = True, stdout: Any = None, stderr: Any = None) -> None:
        super().__init__()
        self._colorize = colorize
        self._stdout = stdout
        self._stderr = stderr
        self._format = os.environ.get("ROSCONSOLE_FORMAT", "[${severity}] [${time}]: ${message}")

    def emit(self, record: logging.LogRecord) -> None:
        """Write a message."""
        severity = _SEVERITY_NAMES.get(record.levelname, record.levelname)
        message = record.getMessage()
        if record.exc_info:
            message += "\n" + logging.Formatter().formatException(record.exc_info)
        text = self._format
        values = {
            "message": message,
            "severity": severity,
            "walltime": f"{time.time():f}",
            "time": f"{time.time():f}",
            "thread": str(record.thread),
            "logger": record.name,
            "file": record.pathname,
            "line": str(record.lineno),
            "function": record.funcName,
            "node": PROCESS.node.name if PROCESS.node is not None else "/unnamed",
        }
        for name, value in values.items():
            text = text.replace("${" + name + "}", value)
        stream = (
            (self._stderr or sys.stderr) if severity in ("WARN", "ERROR", "FATAL") else (self._stdout or sys.stdout)
        )
        self._write(stream, text + "\n", _COLORS.get(severity))

    def _write(self, fd: Any, msg: str, color: str | None) -> None:
        if self._colorize and color and hasattr(fd, "isatty") and fd.isatty():
            msg = f"{color}{msg}\033[0m"
        fd.write(msg)
