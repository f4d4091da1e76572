"""rosgraph, by pyros1: the master and the graph (https://wiki.ros.org/rosgraph)."""

from __future__ import annotations

import sys

from pyros1.drop_in.module_attributes import module_getattr
from rosgraph.masterapi import Master, MasterError, MasterException, MasterFailure
from rosgraph.masterapi import is_online as is_master_online
from rosgraph.rosenv import ROS_HOSTNAME, ROS_IP, ROS_IPV6, ROS_MASTER_URI, ROS_NAMESPACE, get_master_uri

__all__ = [
    "ROS_HOSTNAME",
    "ROS_IP",
    "ROS_IPV6",
    "ROS_MASTER_URI",
    "ROS_NAMESPACE",
    "Master",
    "MasterError",
    "MasterException",
    "MasterFailure",
    "get_master_uri",
    "is_master_online",
    "myargv",
]

__getattr__ = module_getattr(__name__)


def myargv(argv: list[str] | None = None) -> list[str]:
    """Return a command line, by default this program's, without remappings."""
    return [word for word in (sys.argv if argv is None else argv) if ":=" not in word]
