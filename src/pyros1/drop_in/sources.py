"""Finds the Python modules of ROS packages: catkin installs them, but pyros1 imports them from the sources.

A package's setup.py lists their folders (https://wiki.ros.org/catkin/CMakeLists.txt, ``catkin_python_setup``). The file
is only searched for ``package_dir``, never run. After the listed folders, the usual ones, ``src`` and ``python``, are
tried.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator

from pyros1.finding.packages import manifest_text

# These patterns are not compiled here, since few programs have a package with a setup.py.
_PACKAGE_DIR = r"""package_dir\W{1,20}\{([^{}]*)\}"""
_PAIR = r"""["']([\w.]*)["']\s*:\s*["']([^"'\n]*)["']"""
_DEFAULT_FOLDERS = ("src", "python")


def module_folder(package_folder: str, module: str) -> str | None:
    """Return the folder that must be on Python's path to import a Python module of a ROS package.

    Args:
        package_folder: the ROS package's folder.
        module: the name of the module, without dots.

    Returns:
        The folder that contains the module; None if the package has no such module.
    """
    for folder in (
        *_folders_in_setup(package_folder, module),
        *(os.path.join(package_folder, default_folder) for default_folder in _DEFAULT_FOLDERS),
    ):
        path = os.path.join(folder, module)
        if os.path.isfile(os.path.join(path, "__init__.py")) or os.path.isfile(path + ".py"):
            return folder
    return None


def _folders_in_setup(package_folder: str, module: str) -> Iterator[str]:
    """Yield the folders that may contain a module, according to the package's setup.py."""
    try:
        match = re.search(_PACKAGE_DIR, manifest_text(os.path.join(package_folder, "setup.py")))
    except (OSError, ValueError):
        return
    for name, relative_path in re.findall(_PAIR, match[1]) if match else ():
        folder = os.path.normpath(os.path.join(package_folder, relative_path))
        if not name:
            yield folder
        elif name == module and os.path.basename(folder) == module:
            yield os.path.dirname(folder)
