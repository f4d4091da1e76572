"""The functions of rospy: node, parameters, waiting (https://wiki.ros.org/rospy/Overview)."""

from __future__ import annotations

import sys
from typing import Any

import pyros1
from pyros1.drop_in.process import PROCESS
from pyros1.ground.errors import NodeShutdownError, ParameterNotSetError, WaitTimeoutError
from rospy.core import add_client_shutdown_hook
from rospy.exceptions import ROSException, ROSInitException, ROSInterruptException
from rospy.msproxy import MasterProxy
from rospy.names import resolve_name

DEBUG, INFO, WARN, ERROR, FATAL = 1, 2, 4, 8, 16
_LEVELS = {DEBUG: "debug", INFO: "info", WARN: "warn", ERROR: "error", FATAL: "fatal"}


class _Unspecified:
    """Stands for an argument that was not given."""


_unspecified = _Unspecified()


def init_node(
    name: str,
    argv: list[str] | None = None,
    anonymous: bool = False,
    log_level: int | None = None,
    disable_rostime: bool = False,
    disable_rosout: bool = False,
    disable_signals: bool = False,
    xmlrpc_port: int = 0,
    tcpros_port: int = 0,
) -> None:
    """Start the program's node; returns when the master knows it.

    Raises:
        ROSException: there is a node already, started with other arguments.
        ROSInitException: the node could not be started.
        ValueError: the name is not legal.
    """
    if "/" in name:
        raise ValueError("namespaces are not allowed in node names")
    if not name:
        raise ValueError("name must not be empty")
    arguments = (name, argv, anonymous, log_level, disable_rostime, disable_signals)
    if PROCESS.node is not None:
        if PROCESS.arguments != arguments:
            raise ROSException(
                f"rospy.init_node() has already been called with different arguments: {PROCESS.arguments}"
            )
        return
    options: dict[str, Any] = {"log_level": _LEVELS[log_level]} if log_level is not None else {}

    def make() -> pyros1.Node:
        return pyros1.Node(
            name,
            argv=argv,
            anonymous=anonymous,
            handle_signals=not disable_signals,
            rosout=not disable_rosout,
            **options,
        )

    PROCESS.start(make, arguments)


def spin() -> None:
    """Wait until the node ends."""
    if PROCESS.node is None:
        raise ROSInitException("client code must call rospy.init_node() first")
    PROCESS.node.spin()


def myargv(argv: list[str] | None = None) -> list[str]:
    """Return the command line without remappings."""
    return [word for word in (sys.argv if argv is None else argv) if ":=" not in word]


def on_shutdown(h: Any) -> None:
    """Call a function when the node ends; at once, if it has ended."""
    add_client_shutdown_hook(h)


def get_master(env: Any = None) -> MasterProxy:
    """Return the master."""
    return MasterProxy()


def get_published_topics(namespace: str = "/") -> list[list[str]]:
    """Return the topics that are published, with their types."""
    return list(get_master().client.get_published_topics(namespace))


def wait_for_message(topic: str, topic_type: Any, timeout: Any = None) -> Any:
    """Wait for one message.

    Raises:
        ROSException: none came in time.
        ROSInterruptException: the node is shutting down.
    """
    if PROCESS.node is None:
        raise ROSException("ROS node has not been initialized yet. Please call init_node() first")
    seconds = timeout.to_sec() if hasattr(timeout, "to_sec") else timeout
    try:
        return PROCESS.node.wait_for_message(resolve_name(topic), topic_type, seconds)
    except WaitTimeoutError:
        raise ROSException(f"timeout exceeded while waiting for message on topic {resolve_name(topic)}") from None
    except NodeShutdownError:
        raise ROSInterruptException("rospy shutdown") from None


# Parameters -----------------------------------------------------------------------------------------------------------


def _params() -> Any:
    return get_master().parameters


def get_param(param_name: str, default: Any = _unspecified) -> Any:
    """Return a parameter's value, or the default; raises KeyError without one."""
    try:
        return _params()[param_name]
    except ParameterNotSetError:
        if default is not _unspecified:
            return default
        raise KeyError(param_name) from None


def get_param_cached(param_name: str, default: Any = _unspecified) -> Any:
    """Return a parameter's value from a copy that the master keeps up to date."""
    if PROCESS.node is None:
        return get_param(param_name, default)
    value = PROCESS.node.params.cached(param_name, _unspecified)
    if value is not _unspecified:
        return value
    if default is not _unspecified:
        return default
    raise KeyError(param_name)


def get_param_names() -> list[str]:
    """Return the names of all parameters."""
    return list(_params().names())


def set_param(param_name: str, param_value: Any) -> None:
    """Set a parameter."""
    _params()[param_name] = param_value


def search_param(param_name: str) -> str | None:
    """Return the full name of the nearest parameter of that name; None if there is none."""
    found: str | None = _params().search(param_name)
    return found


def has_param(param_name: str) -> bool:
    """Return whether a parameter is set."""
    return param_name in _params()


def delete_param(param_name: str) -> None:
    """Delete a parameter; raises KeyError if it is not set."""
    try:
        del _params()[param_name]
    except ParameterNotSetError:
        raise KeyError(param_name) from None


__all__ = [
    name for name in dir() if name[0] != "_" and name not in ("Any", "annotations", "sys", "pyros1", "is_shutdown")
]
