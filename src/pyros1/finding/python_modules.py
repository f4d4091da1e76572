"""Where Python programs find modules: those of stock ROS 1 by pyros1 (`pyros1.drop_in`), or those of the system."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping

DROP_IN_START = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "drop_in", "start")
"""Folder for PYTHONPATH: programs that find it there have our rospy and its siblings, if they have no real rospy."""
MODULES = os.path.join(os.path.dirname(DROP_IN_START), "modules")
"""Folder of our modules."""
SYSTEM_PYTHON = "/usr/bin/python3"
"""The Python for which the system's packages install modules."""
_ANY_PYTHON = ([b"/usr/bin/env", b"python3"], [b"/usr/bin/env", b"python"])
SYSTEM_FOLDERS = ("/usr/lib/", "/usr/share/")
"""Folder of the programs of the system's packages."""


def modules_environment(environ: Mapping[str, str]) -> dict[str, str]:
    """Return the variables with which Python programs find our modules, and can say where pyros1 is if they do not.

    Args:
        environ: environment variables; with ``PYROS1_ROSPY=stock`` nothing is changed.
    """
    if environ.get("PYROS1_ROSPY") == "stock":
        return {}
    paths = [DROP_IN_START, *(part for part in environ.get("PYTHONPATH", "").split(os.pathsep) if part)]
    return {"PYTHONPATH": os.pathsep.join(dict.fromkeys(paths)), "PYROS1_PYTHON": sys.executable}


def system_python(program: str | os.PathLike[str], environ: Mapping[str, str]) -> str:
    """Return the Python that must run a script; empty: the one that its first line names, as for all other programs.

    Scripts of a Linux distribution's packages (Debian's ROS) may ask for the first Python on the PATH, which in a
    virtual environment lacks their modules: those lie where only the system's Python looks.

    Args:
        program: the file.
        environ: environment variables; with ``PYROS1_ROSPY=pyros1`` scripts run in the first Python, which has pyros1.
    """
    path = os.path.realpath(program)
    if (
        not path.startswith(SYSTEM_FOLDERS)
        or environ.get("PYROS1_ROSPY") == "pyros1"
        or not os.path.isfile(SYSTEM_PYTHON)
    ):
        return ""
    try:
        with open(path, "rb") as file:
            first = file.readline(100)
    except OSError:
        return ""
    return SYSTEM_PYTHON if first.startswith(b"#!") and first[2:].split() in _ANY_PYTHON else ""
