"""roslaunch, by pyros1, as a library (https://wiki.ros.org/roslaunch/API%20Usage)."""

from __future__ import annotations

import os
import subprocess
import sys
import traceback
from typing import Any

import pyros1.launch.scripting as _scripting
from pyros1.drop_in.module_attributes import module_getattr
from roslaunch import (
    arg_dump,
    config,
    core,
    depends,
    launch,
    loader,
    node_args,
    nodeprocess,
    param_dump,
    parent,
    pmon,
    rlutil,
    scriptapi,
    substitution_args,
    xmlloader,
)
from roslaunch.config import ROSLaunchConfig
from roslaunch.core import Master, Node, RLException, Test, rl_errors
from roslaunch.launch import ROSLaunchRunner
from roslaunch.nodeprocess import DEFAULT_TIMEOUT_SIGINT, DEFAULT_TIMEOUT_SIGTERM
from roslaunch.pmon import Process
from roslaunch.scriptapi import ROSLaunch
from roslaunch.xmlloader import XmlLoader, XmlParseException

NAME = "roslaunch"
NUM_WORKERS = 3
DEFAULT_MASTER_PORT = 11311

__all__ = [
    "DEFAULT_MASTER_PORT",
    "DEFAULT_TIMEOUT_SIGINT",
    "DEFAULT_TIMEOUT_SIGTERM",
    "NAME",
    "NUM_WORKERS",
    "Master",
    "Node",
    "Process",
    "RLException",
    "ROSLaunch",
    "ROSLaunchConfig",
    "ROSLaunchRunner",
    "Test",
    "XmlLoader",
    "XmlParseException",
    "arg_dump",
    "config",
    "configure_logging",
    "core",
    "depends",
    "handle_exception",
    "launch",
    "loader",
    "main",
    "node_args",
    "nodeprocess",
    "param_dump",
    "parent",
    "pmon",
    "rlutil",
    "scriptapi",
    "substitution_args",
    "write_pid_file",
    "xmlloader",
]


@rl_errors
def configure_logging(uuid: str) -> None:
    """Create the log folder of a run.

    Args:
        uuid: the run id; see `rlutil.get_or_generate_uuid`.
    """
    _scripting.configure_logging(uuid)


def write_pid_file(options_pid_fn: str | None, options_core: bool, port: int | None) -> None:
    """Write this process's id to a file.

    Args:
        options_pid_fn: the file; None for a core's default file, or for no file if this is not a core.
        options_core: whether this is a core.
        port: the core's port; None for the default.
    """
    path = os.path.expanduser(options_pid_fn) if options_pid_fn else ""
    if not path and options_core:
        from pyros1.launch.running.logs import ros_home

        path = str(ros_home(os.environ) / f"roscore-{port or DEFAULT_MASTER_PORT}.pid")
    if path:
        with open(path, "w", encoding="utf-8") as file:
            file.write(str(os.getpid()))


def handle_exception(roslaunch_core: Any, logger: Any, msg: str, e: BaseException) -> None:
    """Log an error, print it, and exit with code 1.

    Args:
        roslaunch_core: the module `core`.
        logger: a logger of Python.
        msg: text to put before the error's text.
        e: the error.
    """
    roslaunch_core.printerrlog(f"{msg}{e}")
    roslaunch_core.printerrlog("The traceback for the exception was written to the log file")
    logger.error(traceback.format_exc())
    sys.exit(1)


def main(argv: list[str] = sys.argv) -> None:
    """Launch files, as the command ``pyros1 launch`` does, in another process; exit with its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    sys.exit(subprocess.call([sys.executable, "-m", "pyros1", "launch", *argv[1:]]))


__getattr__ = module_getattr(
    "roslaunch",
    child="`pyros1 launch` runs nodes on other machines itself",
    remote="`pyros1 launch` runs nodes on other machines itself",
    remoteprocess="`pyros1 launch` runs nodes on other machines itself",
    server="`pyros1 launch` runs nodes on other machines itself",
    netapi="see `pyros1 launch --list` and the command rosnode",
)
