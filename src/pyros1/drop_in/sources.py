"""Where ROS packages keep their own Python modules: catkin installs them, and pyros1 imports them from the sources.

A package's setup.py names them (https://wiki.ros.org/catkin/CMakeLists.txt, ``catkin_python_setup``). It is only
read, never run; if it cannot be understood, the usual places count: ``src`` and ``python``.
"""

from __future__ import annotations

import ast
import os
from collections.abc import Iterator

_MOST = 1 << 18
"""Most bytes of a setup.py that are read."""
_USUAL = ("src", "python")


def folder_of(package: str, module: str) -> str | None:
    """Return the folder that a package puts on Python's path for a module.

    Args:
        package: the package's folder.
        module: name of the module, without dots.

    Returns:
        The folder that holds the module, or None if the package has no such module.
    """
    for folder in (*_named(package, module), *(os.path.join(package, usual) for usual in _USUAL)):
        path = os.path.join(folder, module)
        if os.path.isfile(os.path.join(path, "__init__.py")) or os.path.isfile(path + ".py"):
            return folder
    return None


def _named(package: str, module: str) -> Iterator[str]:
    """Yield the folders of a module by the package's setup.py."""
    folders = _package_dir(os.path.join(package, "setup.py"))
    if module in folders:
        where = os.path.normpath(os.path.join(package, folders[module]))
        if os.path.basename(where) == module:
            yield os.path.dirname(where)
    if "" in folders:
        yield os.path.normpath(os.path.join(package, folders[""]))


def _package_dir(path: str) -> dict[str, str]:
    try:
        with open(path, "rb") as file:
            tree = ast.parse(file.read(_MOST))
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
        return {}
    for call in ast.walk(tree):
        if not isinstance(call, (ast.Call, ast.Dict)):
            continue
        pairs = (
            ((word.arg, word.value) for word in call.keywords)
            if isinstance(call, ast.Call)
            else ((getattr(key, "value", None), value) for key, value in zip(call.keys, call.values, strict=True))
        )
        for name, value in pairs:
            if name == "package_dir" and isinstance(value, ast.Dict):
                return {
                    key.value: where.value
                    for key, where in zip(value.keys, value.values, strict=True)
                    if isinstance(key, ast.Constant)
                    and isinstance(where, ast.Constant)
                    and isinstance(key.value, str)
                    and isinstance(where.value, str)
                }
    return {}
