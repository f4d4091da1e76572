"""roslib's names for the environment variables of rosgraph and rospkg."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import rosgraph.rosenv
from rosgraph.rosenv import ROS_HOSTNAME, ROS_IP, ROS_MASTER_URI, ROS_NAMESPACE
from rospkg.environment import (
    ROS_HOME,
    ROS_LOG_DIR,
    ROS_PACKAGE_PATH,
    ROS_ROOT,
    get_log_dir,
    get_ros_home,
    get_test_results_dir,
)

from pyros1.drop_in.module_attributes import module_getattr

_Environ = Mapping[str, str] | None

__getattr__ = module_getattr(__name__, makedirs_with_parent_perms="use os.makedirs, or rosgraph.roslogging")


class ROSEnvException(Exception):
    """A variable is not set."""


def _check_required(name: str, value: str | None, required: bool) -> str | None:
    if required and value is None:
        raise ROSEnvException(f"{name} has not been configured")
    return value


def get_ros_root(required: bool = True, env: _Environ = None) -> str | None:
    """Return ROS_ROOT; raises ROSEnvException if it is required and not set."""
    return _check_required(ROS_ROOT, (os.environ if env is None else env).get(ROS_ROOT), required)


def get_ros_package_path(required: bool = False, env: _Environ = None) -> str | None:
    """Return ROS_PACKAGE_PATH; raises ROSEnvException if it is required and not set."""
    return _check_required(ROS_PACKAGE_PATH, (os.environ if env is None else env).get(ROS_PACKAGE_PATH), required)


def get_master_uri(required: bool = True, env: _Environ = None, argv: list[str] | None = None) -> str | None:
    """Return the master's address from the command line or ROS_MASTER_URI.

    Raises:
        ROSEnvException: neither is set, and the address is required.
    """
    environ: dict[str, Any] = {ROS_MASTER_URI: None, **(os.environ if env is None else env)}  # instead of the default
    try:
        return _check_required(ROS_MASTER_URI, rosgraph.rosenv.get_master_uri(environ, argv), required)
    except ValueError as error:
        raise ROSEnvException(str(error)) from None
