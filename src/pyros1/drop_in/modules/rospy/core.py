"""The node's initialization, shutdown and log (https://wiki.ros.org/rospy/Overview/Initialization%20and%20Shutdown)."""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Callable, Mapping
from types import FrameType
from typing import Any

from pyros1.drop_in.module_attributes import module_hooks as _module_hooks
from pyros1.drop_in.process import PROCESS
from pyros1.ground.interrupts import InterruptCounter, die_by_signal
from rospy.exceptions import ROSException, ROSInitException
from rospy.impl.loggers import *  # noqa: F403  the log functions
from rospy.impl.validators import ParameterInvalid
from rospy.names import *  # noqa: F403
from rospy.names import LAZY_IMPORTS, SEP, valid_name

ROSRPC = "rosrpc://"
MASTER_NAME = "master"
_overrides: dict[str, Any] = {}
"""Values that the program has set, which override the node's: ``initialized``, ``uri``."""


# Start and shutdown ---------------------------------------------------------------------------------------------------


def is_initialized() -> bool:
    """Return whether the node has been started, or the value set with `set_initialized`."""
    return _overrides.get("initialized", PROCESS.node is not None)


def set_initialized(initialized: bool) -> None:
    """Set the result of `is_initialized` until the node is started. This does not start the node."""
    _overrides["initialized"] = initialized
    PROCESS.add_start_callback(lambda _: _overrides.pop("initialized", None))


def is_shutdown() -> bool:
    """Return whether the node has shut down; False while the functions passed to `on_shutdown` are running."""
    return PROCESS.is_shutdown


def is_shutdown_requested() -> bool:
    """Return whether the node is about to shut down, or has shut down."""
    return PROCESS.shutdown_requested


def signal_shutdown(reason: str) -> None:
    """Shut down the node.

    Args:
        reason: the reason to log.
    """
    PROCESS.shutdown(reason)


def _require_callable(hook: object) -> None:
    if not callable(hook):
        raise TypeError(f"shutdown hook [{hook}] must be a function or callable object: {type(hook)}")


def add_client_shutdown_hook(h: Callable[[], object]) -> None:
    """Call a function when the node is about to shut down, while topics, services and sleeps still work.

    The function is called immediately if the node has already shut down.

    Raises:
        TypeError: ``h`` cannot be called.
    """
    _require_callable(h)
    PROCESS.on_shutdown(lambda _: h())


def add_preshutdown_hook(h: Callable[[str], object]) -> None:
    """Call a function with the reason when the node is about to shut down, after all client shutdown hooks.

    Raises:
        TypeError: ``h`` cannot be called.
    """
    _require_callable(h)
    PROCESS.on_shutdown(h, "before")


def add_shutdown_hook(h: Callable[[str], object]) -> None:
    """Call a function with the reason once `is_shutdown` is true.

    Raises:
        TypeError: ``h`` cannot be called.
    """
    _require_callable(h)
    PROCESS.on_shutdown(h, "after")


_signalChain: dict[int, Any] = {}
_interrupts = InterruptCounter()


def _ros_signal(sig: int, stackframe: FrameType | None) -> None:
    """Shut down the node, during which the main thread does nothing else; then call the previous handler."""
    counts = _interrupts.count_signal()
    if PROCESS.is_starting and signal.getsignal(sig) is not _ros_signal:
        return  # the node's own handler, which is already installed, handles the signal
    if PROCESS.node is None:  # the node could not be started
        _call_previous_handler(sig, stackframe)
        return
    if counts and _interrupts.count > 1:  # the program has ignored the first signal
        if sig == signal.SIGINT:
            raise KeyboardInterrupt
        die_by_signal(sig)
    signal_shutdown(f"signal-{sig}")
    if _signalChain.get(sig) != signal.SIG_DFL:
        # Python's own handler raises KeyboardInterrupt, which would end programs that check for shutdown themselves.
        with contextlib.suppress(KeyboardInterrupt):
            _call_previous_handler(sig, stackframe)


def _call_previous_handler(sig: int, stackframe: FrameType | None) -> None:
    """Call the previous handler of a signal."""
    previous_handler = _signalChain.get(sig)
    if callable(previous_handler):
        previous_handler(sig, stackframe)
    elif previous_handler == signal.SIG_DFL:
        die_by_signal(sig)


def register_signals() -> None:
    """Let SIGINT and SIGTERM shut down the node.

    Raises:
        ValueError: this is not the main thread.
    """
    for number in (signal.SIGTERM, signal.SIGINT):
        previous_handler = signal.signal(number, _ros_signal)
        if previous_handler is not _ros_signal:
            _signalChain[number] = previous_handler


# Addresses ------------------------------------------------------------------------------------------------------------


def get_node_uri() -> str | None:
    """Return the URI of the node's API, or the value set with `set_node_uri`; None if there is neither."""
    return _overrides.get("uri", PROCESS.node.uri if PROCESS.node is not None else None)


def set_node_uri(uri: str | None) -> None:
    """Set the result of `get_node_uri` until the node is started. This does not change the node's URI."""
    _overrides["uri"] = uri
    PROCESS.add_start_callback(lambda _: _overrides.pop("uri", None))


def get_ros_root(required: bool = False, env: Mapping[str, str] | None = None) -> str | None:
    """Return the environment variable ROS_ROOT.

    Raises:
        ROSException: the variable is required, but not set.
    """
    root = (os.environ if env is None else env).get("ROS_ROOT")
    if required and not root:
        raise ROSException("ROS_ROOT is not set")
    return root


def parse_rosrpc_uri(uri: str) -> tuple[str, int]:
    """Return the host and port in a service's URI.

    Raises:
        ParameterInvalid: ``uri`` is not a valid URI.
    """
    from urllib.parse import urlparse

    if not uri.startswith(ROSRPC):
        raise ParameterInvalid(f"Invalid protocol for ROS service URL: {uri}")
    try:
        parts = urlparse(uri)
        if parts.hostname and parts.port:
            return parts.hostname, parts.port
    except ValueError:
        pass  # raised for an invalid port
    raise ParameterInvalid(f"ROS service URL is invalid: {uri}")


def xmlrpcapi(uri: str | None, cache: bool = True) -> Any:
    """Return an `xmlrpc.client` proxy for the API at a URI; None if the URI is not valid."""
    from urllib.parse import urlparse
    from xmlrpc.client import ServerProxy

    if not uri or not urlparse(uri).netloc:
        return None
    return ServerProxy(uri)


def is_topic(param_name: str) -> Callable[[Any, str], str]:
    """Return a function that checks a topic name: called with (name, caller id), it returns the full name, or raises
    ParameterInvalid if the name is not legal.
    """
    validate = valid_name(param_name)

    def check(value: Any, caller_id: str) -> str:
        if value == SEP:
            raise ParameterInvalid(f"ERROR: parameter [{param_name}] cannot be the global namespace")
        return validate(value, caller_id)

    return check


_lazy_imports = {**LAZY_IMPORTS, "rosgraph": "rosgraph.", "Log": "rosgraph_msgs.msg", "NullHandler": "logging"}
_lazy_imports |= dict.fromkeys(("configure_logging", "deprecated"), "rospy.impl.without_node")
_lazy_imports |= {"_base_logger": "rospy.impl.loggers"}
_process_attributes = {"_in_shutdown": "shutdown_requested", "_shutdown_flag": "is_shutdown"}
_hooks_reason = "add functions with rospy.on_shutdown, or add_client_shutdown_hook and its siblings"
_lazy_getattr, __dir__ = _module_hooks(
    __name__,
    _lazy_imports,
    dict.fromkeys(("_client_shutdown_hooks", "_preshutdown_hooks", "_shutdown_hooks"), _hooks_reason),
    {"_uri": get_node_uri},
)


def __getattr__(name: str) -> Any:
    if name in _process_attributes:
        return getattr(PROCESS, _process_attributes[name])
    return _lazy_getattr(name)
