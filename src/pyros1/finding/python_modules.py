"""Where Python programs find the modules of stock ROS 1 by pyros1: `pyros1.drop_in`."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping

START = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "drop_in", "start")
"""Folder for PYTHONPATH: programs that find it there have our rospy and its siblings, if they have no real rospy."""


def modules_environment(environ: Mapping[str, str]) -> dict[str, str]:
    """Return the variables with which Python programs find our modules, and can say where pyros1 is if they do not.

    Args:
        environ: environment variables; with ``PYROS1_ROSPY=stock`` nothing is changed.
    """
    if environ.get("PYROS1_ROSPY") == "stock":
        return {}
    paths = [START, *(part for part in environ.get("PYTHONPATH", "").split(os.pathsep) if part)]
    return {"PYTHONPATH": os.pathsep.join(dict.fromkeys(paths)), "PYROS1_PYTHON": sys.executable}
