"""Determines which ROS modules Python programs import: pyros1's replacements (`pyros1.drop_in`), or the system's."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping

DROP_IN_START = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "drop_in", "start")
"""Folder for PYTHONPATH, which provides our rospy and related modules to programs without a real rospy."""
MODULES_FOLDER = os.path.join(os.path.dirname(DROP_IN_START), "modules")
"""Folder of the replacement modules."""
SYSTEM_PYTHON = "/usr/bin/python3"
"""The Python interpreter for which the system's packages install modules."""
_FIRST_PYTHON_ON_PATH = ([b"/usr/bin/env", b"python3"], [b"/usr/bin/env", b"python"])
SYSTEM_FOLDERS = ("/usr/lib/", "/usr/share/")
"""Folders with programs from the system's packages."""


def modules_environment(environ: Mapping[str, str]) -> dict[str, str]:
    """Return environment variables that let Python programs find our modules. In an interpreter without pyros1, they
    make programs report where pyros1 is installed.

    Args:
        environ: environment variables; with ``PYROS1_ROSPY=stock``, nothing is changed.
    """
    if environ.get("PYROS1_ROSPY") == "stock":
        return {}
    paths = [DROP_IN_START, *(part for part in environ.get("PYTHONPATH", "").split(os.pathsep) if part)]
    return {"PYTHONPATH": os.pathsep.join(dict.fromkeys(paths)), "PYROS1_PYTHON": sys.executable}


def system_python(program: str | os.PathLike[str], environ: Mapping[str, str]) -> str:
    """Return the interpreter that must run a script, or an empty string for the interpreter in the script's first line.

    Scripts in a Linux distribution's packages (Debian's ROS) may request the first Python on the PATH. In a virtual
    environment, that Python lacks their modules, which are installed where only the system's Python finds them.

    Args:
        program: path of the script.
        environ: environment variables; with ``PYROS1_ROSPY=pyros1``, scripts run in the first Python on the PATH, which
            has pyros1.
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
            first_line = file.readline(100)
    except OSError:
        return ""
    return SYSTEM_PYTHON if first_line.startswith(b"#!") and first_line[2:].split() in _FIRST_PYTHON_ON_PATH else ""
