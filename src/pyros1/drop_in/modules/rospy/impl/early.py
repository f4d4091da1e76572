"""What programs do before, or without, a node."""

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
        node_name: the file's name comes from it, unless ``__log:=PATH`` is on the command line.
        level: least level of the messages.

    Raises:
        ROSException: the name is empty.
    """
    name = node_name.replace("/", "_").removeprefix("_")
    given = get_mappings().get("__log")
    if not name and not given:
        raise ROSException(f"invalid configure_logging parameter: {node_name}")
    _configure("rospy", level, filename=os.path.abspath(given) if given else f"{name}.log")


def deprecated(func: F) -> F:
    """Return a function that warns before it calls another."""

    @functools.wraps(func)
    def warned(*args: Any, **kwargs: Any) -> Any:
        warnings.warn(f"Call to deprecated function {func.__name__}.", DeprecationWarning, stacklevel=2)
        return func(*args, **kwargs)

    return warned  # type: ignore[return-value]  # it has the same arguments
