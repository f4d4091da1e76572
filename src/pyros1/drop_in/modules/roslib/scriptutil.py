"""Scripts that talk to the master, from before rosgraph."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from typing import Any

from rosgraph.names import script_resolve_name

from pyros1.drop_in.missing import missing

__getattr__ = missing(__name__)


def deprecated(func: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that warns that it is old."""

    @functools.wraps(func)
    def wrapped(*args: Any, **kwargs: Any) -> Any:
        import warnings

        warnings.warn(f"Call to deprecated function {func.__name__}.", DeprecationWarning, stacklevel=2)
        return func(*args, **kwargs)

    return wrapped


def get_master() -> Any:
    """Return a proxy of the master's XML-RPC API, whose methods want the caller's name first."""
    from xmlrpc.client import ServerProxy

    return ServerProxy(os.environ["ROS_MASTER_URI"])


get_param_server = get_master
