"""The node's life and its log (https://wiki.ros.org/rospy/Overview/Logging)."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any
from urllib.parse import urlparse

from pyros1.drop_in.process import PROCESS
from rospy.exceptions import *  # noqa: F403
from rospy.names import *  # noqa: F403

ROSRPC = "rosrpc://"
MASTER_NAME = "master"


def is_initialized() -> bool:
    """Return whether there is a node."""
    return PROCESS.node is not None


def is_shutdown() -> bool:
    """Return whether the node has ended."""
    return PROCESS.is_shutdown


is_shutdown_requested = is_shutdown


def signal_shutdown(reason: str) -> None:
    """End the node."""
    if PROCESS.node is not None:
        PROCESS.node.shutdown(reason)


def add_client_shutdown_hook(hook: Callable[[], object]) -> None:
    """Call a function when the node ends."""
    if not callable(hook):
        raise TypeError(f"shutdown hook [{hook}] must be a function or callable object: {type(hook)}")
    PROCESS.on_shutdown(hook)


def add_preshutdown_hook(hook: Callable[[str], object]) -> None:
    """Call a function with the reason when the node ends."""
    PROCESS.on_shutdown(lambda: hook(""))


add_shutdown_hook = add_preshutdown_hook


def get_node_uri() -> str | None:
    """Return the address of the node's API; None without a node."""
    return PROCESS.node.uri if PROCESS.node is not None else None


def get_ros_root(required: bool = False, env: Any = None) -> str | None:
    """Return the environment variable ROS_ROOT."""
    return (os.environ if env is None else env).get("ROS_ROOT")


def parse_rosrpc_uri(uri: str) -> tuple[str, int]:
    """Return host and port of a service's address."""
    parts = urlparse(uri)
    if parts.scheme != "rosrpc" or not parts.hostname or not parts.port:
        raise ParameterInvalid(f"ERROR: invalid service address [{uri}]")
    return parts.hostname, parts.port


class ParameterInvalid(Exception):
    """An argument is not valid."""


# Log ------------------------------------------------------------------------------------------------------------------


def _logging(level: str) -> list[Callable[..., None]]:
    def emit(msg: Any, args: tuple[Any, ...], kwargs: dict[str, Any], **options: Any) -> None:
        node = PROCESS.node
        name = kwargs.get("logger_name")
        if node is None:
            return
        log = node.log.named(name) if name else node.log
        getattr(log, level)(msg, *args, **options)

    def log(msg: Any, *args: Any, **kwargs: Any) -> None:
        emit(msg, args, kwargs)

    def throttle(period: float, msg: Any, *args: Any, **kwargs: Any) -> None:
        emit(msg, args, kwargs, throttle=period)

    def once(msg: Any, *args: Any, **kwargs: Any) -> None:
        emit(msg, args, kwargs, once=True)

    return [log, throttle, once]


logdebug, logdebug_throttle, logdebug_once = _logging("debug")
loginfo, loginfo_throttle, loginfo_once = _logging("info")
logwarn, logwarn_throttle, logwarn_once = _logging("warn")
logerr, logerr_throttle, logerr_once = _logging("error")
logfatal, logfatal_throttle, logfatal_once = _logging("fatal")
logout = loginfo
logerror = logerr
rospydebug = rospyinfo = rospywarn = rospyerr = lambda msg, *args: None

__all__ = [name for name in dir() if name[0] != "_" and name not in ("Any", "Callable", "annotations", "sys")]
