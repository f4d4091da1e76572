"""Folders that environment variables specify (https://wiki.ros.org/ROS/EnvironmentVariables)."""

from __future__ import annotations

import os
from collections.abc import Mapping

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.finding.packages import share_folders

ROS_ROOT = "ROS_ROOT"
ROS_PACKAGE_PATH = "ROS_PACKAGE_PATH"
ROS_HOME = "ROS_HOME"
ROS_LOG_DIR = "ROS_LOG_DIR"
ROS_ETC_DIR = "ROS_ETC_DIR"
ROS_TEST_RESULTS_DIR = "ROS_TEST_RESULTS_DIR"

_Environ = Mapping[str, str] | None

__getattr__ = module_getattr(__name__)


def _get(env: _Environ, name: str) -> str | None:
    return (os.environ if env is None else env).get(name)


def get_ros_root(env: _Environ = None) -> str | None:
    """Return ROS_ROOT; None if it is not set."""
    return _get(env, ROS_ROOT)


def get_ros_package_path(env: _Environ = None) -> str | None:
    """Return ROS_PACKAGE_PATH; None if it is not set."""
    return _get(env, ROS_PACKAGE_PATH)


def get_ros_paths(env: _Environ = None) -> list[str]:
    """Return the folders that are searched for packages."""
    environ = os.environ if env is None else env
    explicit_paths = [get_ros_root(environ), *(get_ros_package_path(environ) or "").split(os.pathsep)]
    return [path for path in (*explicit_paths, *share_folders(environ)) if path]


def get_ros_home(env: _Environ = None) -> str:
    """Return the folder for this user's ROS files."""
    return _get(env, ROS_HOME) or os.path.join(os.path.expanduser("~"), ".ros")


def get_log_dir(env: _Environ = None) -> str:
    """Return the folder for log files."""
    return _get(env, ROS_LOG_DIR) or os.path.join(get_ros_home(env), "log")


def get_test_results_dir(env: _Environ = None) -> str:
    """Return the folder for test results."""
    return _get(env, ROS_TEST_RESULTS_DIR) or os.path.join(get_ros_home(env), "test_results")


def get_etc_ros_dir(env: _Environ = None) -> str:
    """Return the folder of the system's ROS settings."""
    return _get(env, ROS_ETC_DIR) or "/etc/ros"


def on_ros_path(p: str, env: _Environ = None) -> bool:
    """Return whether a path is in a folder that is searched for packages."""
    path = os.path.realpath(p)
    roots = [os.path.realpath(root) for root in get_ros_paths(env)]
    return any(path == root or path.startswith(root.rstrip(os.sep) + os.sep) for root in roots)
