"""Environment variables of ROS (https://wiki.ros.org/ROS/EnvironmentVariables)."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping

from pyros1.drop_in.module_attributes import module_getattr

ROS_MASTER_URI = "ROS_MASTER_URI"
ROS_IP = "ROS_IP"
ROS_IPV6 = "ROS_IPV6"
ROS_HOSTNAME = "ROS_HOSTNAME"
ROS_NAMESPACE = "ROS_NAMESPACE"
DEFAULT_MASTER_PORT = 11311
DEFAULT_MASTER_URI = f"http://localhost:{DEFAULT_MASTER_PORT}/"

__getattr__ = module_getattr(__name__)


def get_master_uri(env: Mapping[str, str] | None = None, argv: list[str] | None = None) -> str:
    """Return the master's address: ``__master:=``, ROS_MASTER_URI or the default.

    Raises:
        ValueError: the command line names an empty address.
    """
    for word in sys.argv if argv is None else argv:
        if word.startswith("__master:="):
            uri = word.partition(":=")[2]
            if not uri:
                raise ValueError(f"__master remapping argument '{word}' improperly specified")
            return uri
    return (os.environ if env is None else env).get(ROS_MASTER_URI, DEFAULT_MASTER_URI)
