"""rosgraph, by pyros1: the master and the graph (https://wiki.ros.org/rosgraph)."""

import sys

from rosgraph.masterapi import Master, MasterError, MasterException, MasterFailure
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


def myargv(argv: list[str] | None = None) -> list[str]:
    """Return the command line without remappings."""
    return [word for word in (sys.argv if argv is None else argv) if ":=" not in word]


def is_master_online(master_uri: str | None = None) -> bool:
    """Return whether a master answers."""
    return Master("rosgraph", master_uri).is_online()
