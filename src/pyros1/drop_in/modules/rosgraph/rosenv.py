"""Environment variables of ROS (https://wiki.ros.org/ROS/EnvironmentVariables)."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping

from pyros1.ground import names
from pyros1.net.hosts import master_uri

ROS_MASTER_URI = "ROS_MASTER_URI"
ROS_IP = "ROS_IP"
ROS_IPV6 = "ROS_IPV6"
ROS_HOSTNAME = "ROS_HOSTNAME"
ROS_NAMESPACE = "ROS_NAMESPACE"
DEFAULT_MASTER_PORT = 11311


def get_master_uri(env: Mapping[str, str] | None = None, argv: list[str] | None = None) -> str:
    """Return the master's address: ``__master:=``, ROS_MASTER_URI or the default."""
    special = names.parse_arguments(list(sys.argv if argv is None else argv)).special
    return master_uri(os.environ if env is None else env, special)
