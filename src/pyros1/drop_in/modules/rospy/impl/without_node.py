"""Functions of `rospy.core` that work without a node: logging configuration, and a decorator."""

from __future__ import annotations

import functools
import logging
import os
import warnings
from collections.abc import Callable
from typing import Any, TypeVar

from rosgraph.roslogging import configure_logging as _configure

from rospy.exceptions import ROSException
from rospy.names import get_mappings

F = TypeVar("F", bound=Callable[..., Any])


def configure_logging(node_name: str, level: int = logging.INFO) -> None:
    """Write the messages of Python's logging to a file; a node does so by itself.

    Args:
        node_name: determines the name of the file, unless ``__log:=PATH`` is on the command line.
        level: minimum level of the messages.

    Raises:
        ROSException: the name is empty.
    """
    name = node_name.replace("/", "_").removeprefix("_")
    log_path = get_mappings().get("__log")
    if not name and not log_path:
        raise ROSException(f"invalid configure_logging parameter: {node_name}")
    _configure("rospy", level, filename=os.path.abspath(log_path) if log_path else f"{name}.log")


def deprecated(func: F) -> F:
    """Return a function that issues a DeprecationWarning, and then calls ``func``."""

    @functools.wraps(func)
    def warn_and_call(*args: Any, **kwargs: Any) -> Any:
        warnings.warn(f"Call to deprecated function {func.__name__}.", DeprecationWarning, stacklevel=2)
        return func(*args, **kwargs)

    return warn_and_call  # type: ignore[return-value]  # it has the same arguments
