"""The command roslaunch-logs, which prints the folder of the log files."""

from __future__ import annotations

import sys
from typing import Any

import rosgraph

from pyros1.drop_in.commands import main as _main

NAME = "roslaunch-logs"


def get_run_id() -> Any:
    """Return the run id of the running master; None if no master is running."""
    try:
        return rosgraph.Master("/roslaunch").getParam("/run_id")
    except (rosgraph.MasterException, OSError):
        return None


def logs_main() -> None:
    """Print the log folder of the running master; if no master is running, print the log folder of all runs, and exit
    with code 2.
    """
    _main("roslaunch", [sys.argv[0], "--logs", *sys.argv[1:]])
