"""Access to the master for scripts; this module is older than rosgraph."""

from __future__ import annotations

import os
from typing import Any

from rosgraph.names import script_resolve_name

from pyros1.drop_in.module_attributes import module_getattr

__getattr__ = module_getattr(__name__)


def get_master() -> Any:
    """Return a proxy for the master's XML-RPC API; the first argument of its methods is the caller's name."""
    from xmlrpc.client import ServerProxy

    return ServerProxy(os.environ["ROS_MASTER_URI"])


get_param_server = get_master
