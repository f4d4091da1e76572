"""Environment variables, from before rospkg and rosgraph."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping

from rosgraph.rosenv import ROS_HOSTNAME, ROS_IP, ROS_MASTER_URI, ROS_NAMESPACE
from rospkg.environment import (
    ROS_HOME,
    ROS_LOG_DIR,
    ROS_PACKAGE_PATH,
    ROS_ROOT,
    get_log_dir,
    get_ros_home,
)

from pyros1.drop_in.missing import missing

_NO_ROOT = """
The ROS_ROOT environment variable has not been set.
Please set to the location of your ROS installation
before continuing.
"""
ROS_BINDEPS_PATH = "ROS_BINDEPS_PATH"
ROS_BOOST_ROOT = "ROS_BOOST_ROOT"

_Environ = Mapping[str, str] | None

__getattr__ = missing(__name__)


class ROSEnvException(Exception):
    """A variable is not set."""


def _variable(name: str, required: bool, env: _Environ, complaint: str = "") -> str | None:
    value = (os.environ if env is None else env).get(name)
    if required and value is None:
        raise ROSEnvException(complaint or f"{name} has not been configured")
    return value


def get_test_results_dir(env: _Environ = None) -> str:
    """Return the folder of test results in ROS_HOME."""
    return os.path.join(get_ros_home(env), "test_results")


def get_ros_root(required: bool = True, env: _Environ = None) -> str | None:
    """Return ROS_ROOT; raises ROSEnvException if it must be set and is not."""
    return _variable(ROS_ROOT, required, env, _NO_ROOT)


def get_ros_package_path(required: bool = False, env: _Environ = None) -> str | None:
    """Return ROS_PACKAGE_PATH; raises ROSEnvException if it must be set and is not."""
    return _variable(ROS_PACKAGE_PATH, required, env)


def get_master_uri(required: bool = True, env: _Environ = None, argv: list[str] | None = None) -> str | None:
    """Return the master's address, of the command line or ROS_MASTER_URI; raises ROSEnvException if there is none."""
    for word in sys.argv if argv is None else argv:
        if word.startswith("__master:="):
            value = word.partition(":=")[2]
            if not value:
                raise ROSEnvException(f"__master remapping argument '{word}' improperly specified")
            return value
    return _variable(ROS_MASTER_URI, required, env)


def makedirs_with_parent_perms(p: str) -> None:
    """Make a folder, and those above it, with the permissions of the first that is there."""
    from rosgraph.roslogging import makedirs_with_parent_perms as make

    make(p)
