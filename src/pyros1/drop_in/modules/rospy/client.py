"""Functions of rospy that start the node, access parameters and wait (https://wiki.ros.org/rospy/Overview)."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import pyros1
from pyros1.drop_in.binary import bytes_to_binary
from pyros1.drop_in.module_attributes import module_hooks as _module_hooks
from pyros1.drop_in.process import PROCESS
from pyros1.ground import names
from pyros1.ground.errors import (
    MasterError,
    NodeError,
    NodeShutdownError,
    ProtocolError,
    SerializationError,
    WaitTimeoutError,
)
from pyros1.ground.loading import loading
from rospy.core import add_client_shutdown_hook, logdebug, logerr, loginfo, logwarn, register_signals, signal_shutdown
from rospy.exceptions import ROSException, ROSInitException, ROSInterruptException
from rospy.msproxy import MasterProxy, stock_connection_errors
from rospy.names import get_caller_id, normalize_name_argument, resolve_name

DEBUG, INFO, WARN, ERROR, FATAL = 1, 2, 4, 8, 16
TIMEOUT_READY = 15.0
_LOCAL_BUFFER_SIZE = 1 << 20
"""Bytes that stock's sockets buffer, even within a process: bursts of more than `queue_size` messages still arrive."""


_NAMESPACE = "__ns:="


class _Unspecified:
    """Marks an argument that was not passed."""


_unspecified = _Unspecified()


def myargv(argv: list[str] | None = None) -> list[str]:
    """Return the command line without remappings and private parameters.

    Args:
        argv: the command line; None for ``sys.argv``.
    """
    arguments = names.parse_arguments(list(sys.argv if argv is None else argv))
    return [word for word in (sys.argv if argv is None else argv) if word in arguments.rest]


def load_command_line_node_params(argv: list[str]) -> dict[str, Any]:
    """Return the private parameters on a command line. The values are YAML; ``deg(90)`` is not converted to a number.

    Raises:
        ROSInitException: a value is not YAML, or an argument contains ``:=`` twice.
    """
    # Stock ignores arguments that contain a newline.
    arguments = names.parse_arguments([word for word in argv if "\n" not in word])
    try:
        if arguments.malformed:
            raise ValueError(f"{arguments.malformed[0]!r} has more than one ':='")
        return {key: _parse_value(text.strip()) for key, text in arguments.parameters.items() if key and text.strip()}
    except Exception as error:
        raise ROSInitException(f"invalid command-line parameters: {error}") from error


def _parse_value(text: str) -> Any:
    from pyros1.node.parameters.private import parse_plain_value

    plain_value = parse_plain_value(text)
    if plain_value is not None:
        return plain_value
    import yaml

    return yaml.safe_load(text)


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
    """Start the program's node, and return once it is registered with the master. Repeating the call has no effect.

    Args:
        name: base name. ``__name:=`` on the command line replaces it.
        argv: command line with remappings; None for ``sys.argv``.
        anonymous: whether to make the name unique.
        log_level: rospy.DEBUG to rospy.FATAL; None for INFO.
        disable_rostime: whether to use wall time and ignore /use_sim_time.
        disable_rosout: whether to disable publishing on /rosout.
        disable_signals: whether to leave SIGINT and SIGTERM alone.
        xmlrpc_port, tcpros_port: the ports; 0 for any.

    Raises:
        ROSException: the node has already been started with other arguments.
        ROSInitException: the node could not be started, or a private parameter on the command line is not valid YAML.
        TypeError, OverflowError: XML-RPC cannot transfer the value of a private parameter.
        ValueError: the name is not legal, or this is not the main thread and ``disable_signals`` is false.
    """
    if not name:
        raise ValueError("name must not be empty")
    if "/" in name:
        raise ValueError("namespaces are not allowed in node names")
    command_line = list(sys.argv if argv is None else argv)
    arguments = (name, command_line, anonymous, log_level, disable_rostime, disable_signals)
    with loading():
        from rospy.impl import rosout

    with PROCESS.start_lock:  # other threads wait for the same node
        if PROCESS.node is not None:
            if PROCESS.arguments != arguments:
                raise ROSException(
                    f"rospy.init_node() has already been called with different arguments: {PROCESS.arguments}"
                )
            return
        if not names.is_legal_base_name(name):
            text = f"'{name}' is not a legal ROS base name. This may cause problems with other ROS tools."
            warnings.warn(text, stacklevel=2)
        level = INFO if log_level is None else log_level
        rosout.python_level(level)  # KeyError: unknown level
        if not disable_signals and not hasattr(sys, "ps1"):
            register_signals()

        def make_node() -> pyros1.Node:
            config = rosout.configure(level)
            private_params = load_command_line_node_params(command_line)
            namespaces = [word for word in sys.argv if word.startswith(_NAMESPACE)]  # as in stock ROS, not from argv
            node = pyros1.Node(
                name,
                argv=[*(word for word in command_line if not _is_ignored(word)), *namespaces],
                anonymous=anonymous,
                log_level=_LEVELS[level],
                handle_signals=not disable_signals,
                rosout=not disable_rosout,
                wall_time=disable_rostime,
                ports=(xmlrpc_port or 0, tcpros_port or 0),
                strict_names=False,
                local_room=_LOCAL_BUFFER_SIZE,
            )
            try:
                for key, value in private_params.items():
                    with _stock_value_errors(), stock_connection_errors():
                        node.params["~" + key] = value
                rosout.connect_loggers(node, command_line, config)
            except BaseException:  # XML-RPC cannot transfer a value, or the logging configuration is wrong
                node.shutdown()
                raise
            return node

        try:
            PROCESS.start(make_node, arguments)
        except NodeShutdownError:
            raise ROSInitException("init_node interrupted before it could complete") from None
        except ProtocolError as error:
            raise ROSInitException(str(error)) from None
        if not disable_rosout:
            rosout.list_rosout_topic()
    full_name = get_caller_id()
    logdebug("init_node, name[%s], pid[%s]: rospy is pyros1's, %s", full_name, os.getpid(), os.path.dirname(__file__))


def _is_ignored(word: str) -> bool:
    """Return whether to hide an argument from the node: a private parameter, or one that stock ignores."""
    is_private = word.startswith("_") and not word.startswith("__") and ":=" in word
    return is_private or word.startswith(_NAMESPACE) or "\n" in word or word.rstrip().endswith(":=")


_LEVELS = {DEBUG: "debug", INFO: "info", WARN: "warn", ERROR: "error", FATAL: "fatal"}


def spin() -> None:
    """Wait until the node shuts down.

    Raises:
        ROSInitException: there is no node.
    """
    if PROCESS.node is None:
        raise ROSInitException("client code must call rospy.init_node() first")
    try:
        PROCESS.node.spin()
    except KeyboardInterrupt:
        signal_shutdown("keyboard interrupt")


def on_shutdown(h: Callable[[], object]) -> None:
    """Call a function when the node is about to shut down, while topics, services and sleeps still work.

    The function is called immediately if the node has already shut down.

    Raises:
        TypeError: ``h`` cannot be called.
    """
    add_client_shutdown_hook(h)


def get_master(env: Mapping[str, str] | None = None) -> MasterProxy:
    """Return a proxy for the master."""
    return MasterProxy(None)


def get_published_topics(namespace: str = "/") -> list[list[str]]:
    """Return the published topics and their types: ``[[name, type], ...]``.

    Raises:
        ROSException: the master does not respond.
    """
    code, message, value = get_master().getPublishedTopics(resolve_name(namespace))
    if code != 1:
        raise ROSException(f"unable to get published topics: {message}")
    return value


def wait_for_message(topic: str, topic_type: Any, timeout: Any = None) -> Any:
    """Wait for one message.

    Args:
        topic: name of the topic.
        topic_type: message class.
        timeout: seconds of wall time, or a Duration; None for no limit.

    Raises:
        ROSException: no message arrived in time, or the master refuses the topic.
        ROSInterruptException: the node is shutting down.
    """
    from rospy.topics import Subscriber

    if PROCESS.node is None or PROCESS.is_shutdown:
        if PROCESS.is_shutdown:
            raise ROSInterruptException("rospy shutdown")
        raise ROSException("ROS node has not been initialized yet. Please call init_node() first")
    seconds = timeout.to_sec() if hasattr(timeout, "to_sec") else timeout
    # This subscriber validates the arguments, and adds the topic to the program's list of topics.
    validating_subscriber = None if PROCESS.is_forked else Subscriber(topic, topic_type)
    try:
        limit = None if seconds is None else max(0.0, float(seconds))
        if PROCESS.is_forked:
            with _make_node_after_fork(PROCESS.node) as node:
                return node.wait_for_message(resolve_name(topic), topic_type, limit)
        return PROCESS.node.wait_for_message(normalize_name_argument(topic), topic_type, limit)
    except WaitTimeoutError:
        raise ROSException(f"timeout exceeded while waiting for message on topic {topic}") from None
    except NodeShutdownError:
        raise ROSInterruptException("rospy shutdown") from None
    except (MasterError, NodeError) as error:
        raise ROSException(f"unable to wait for a message on topic {topic}: {error}") from None
    finally:
        if validating_subscriber is not None:
            validating_subscriber.unregister()


def _make_node_after_fork(node: pyros1.Node) -> pyros1.Node:
    """Return a new node for a forked process, where the threads of the program's node do not run."""
    special = [
        f"{key}:={text}" for key, text in node.arguments.special.items() if key not in ("__name", "__ns", "__log")
    ]
    base = node.name.rpartition("/")[2]
    return pyros1.Node(
        base, argv=special, anonymous=True, handle_signals=False, rosout=False, wall_time=True, strict_names=False
    )


# Parameters -----------------------------------------------------------------------------------------------------------


def get_param(param_name: str, default: Any = _unspecified) -> Any:
    """Return a parameter's value; a dict for a namespace.

    Args:
        param_name: name of the parameter.
        default: the value to return if the parameter is not set.

    Raises:
        KeyError: the parameter is not set, and there is no default.
    """
    try:
        return get_master()[param_name]
    except KeyError:
        if default is not _unspecified:
            return default
        raise KeyError(param_name) from None


def get_param_cached(param_name: str, default: Any = _unspecified) -> Any:
    """Return a parameter's value from a local copy that the master keeps up to date.

    Args:
        param_name: name of the parameter.
        default: the value to return if the parameter is not set.

    Raises:
        KeyError: the parameter is not set, and there is no default.
    """
    if PROCESS.node is None:
        return get_param(param_name, default)
    master = get_master()
    value = master.call_with_retry(lambda: master.parameters.cached(normalize_name_argument(param_name), _unspecified))
    if value is not _unspecified:
        return bytes_to_binary(value)
    if default is not _unspecified:
        return default
    raise KeyError(param_name)


def get_param_names() -> list[str]:
    """Return the full names of all parameters."""
    return list(get_master())


def set_param(param_name: str, param_value: Any) -> None:
    """Set a parameter.

    Raises:
        TypeError: the value is not a bool, number, str, bytes, or a list or dict of these.
        OverflowError: a number has more than 32 bits.
    """
    try:
        with _stock_value_errors():
            get_master()[param_name] = param_value
    except MasterError as error:  # the master refuses the value, for example a root that is not a dictionary
        logwarn("cannot set parameter [%s]: %s", param_name, error)


@contextmanager
def _stock_value_errors() -> Iterator[None]:
    """In a ``with`` block, raise TypeError or OverflowError, like stock, for values that XML-RPC cannot transfer."""
    try:
        yield
    except SerializationError as error:
        raise (OverflowError if "does not fit" in str(error) else TypeError)(str(error)) from None


def search_param(param_name: str) -> str | None:
    """Search for a parameter from the node's own namespace upwards; return its full name, or None.

    Raises:
        ROSException: the name is private.
        TypeError: the name is None.
    """
    return get_master().search_param(param_name)


def has_param(param_name: str) -> bool:
    """Return whether a parameter is set."""
    return param_name in get_master()


def delete_param(param_name: str) -> None:
    """Delete a parameter.

    Raises:
        KeyError: the parameter is not set.
    """
    del get_master()[param_name]


_lazy_imports = {
    **dict.fromkeys(("GetLoggers", "GetLoggersResponse", "SetLoggerLevel", "SetLoggerLevelResponse"), "roscpp.srv"),
    "Logger": "roscpp.msg",
    "Log": "rosgraph_msgs.msg",
    "Service": "rospy.service",
}
__getattr__, __dir__ = _module_hooks(
    __name__,
    _lazy_imports,
    {"_master_proxy_lock": "pyros1's master proxy is thread-safe without a lock"},
    {"_init_node_args": lambda: PROCESS.arguments, **dict.fromkeys(("_master_proxy", "_param_server"), get_master)},
)
