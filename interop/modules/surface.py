"""Print the public names of Python modules and of their classes as JSON: run on stock's modules and on ours.

::

    python interop/modules/surface.py MODULE...

The answer is ``{module: {name: kind}}``; members of classes are ``Class.member``. A name is public if the module lists
it in ``__all__``, or if it begins without an underscore and belongs to ROS: what a module has only because it imports
it from Python itself, and modules that it imports, do not count. A module that cannot be imported has the value null.
"""

from __future__ import annotations

import contextlib
import importlib
import inspect
import io
import json
import sys
import types
import warnings

FOREIGN = {*sys.stdlib_module_names, "numpy", "yaml", "defusedxml", "catkin_pkg", "__future__"}


def kind(value: object) -> str:
    """Return what a name is."""
    if inspect.isclass(value):
        return "class"
    return "function" if callable(value) else "value"


def belongs(module: str, value: object) -> bool:
    """Tell whether a value is from ROS, as far as one can see."""
    if isinstance(value, types.ModuleType):
        return False
    home = getattr(value, "__module__", None) if callable(value) else None
    if home is None:
        return not type(value).__module__.startswith("__future__")
    return home.partition(".")[0] not in FOREIGN


def names(module: types.ModuleType) -> dict[str, str]:
    """Return the public names of a module, and of its classes, with their kinds."""
    listed = getattr(module, "__all__", None)
    found: dict[str, str] = {}
    for name in sorted(listed if listed is not None else dir(module)):
        value = getattr(module, name, None)
        if listed is None and (name.startswith("_") or not belongs(module.__name__, value)):
            continue
        if isinstance(value, types.ModuleType):
            continue
        found[name] = kind(value)
        if inspect.isclass(value) and not issubclass(value, BaseException):
            for member in sorted(vars(value)):
                if not member.startswith("_"):
                    found[f"{name}.{member}"] = "member"
            for member in dir(value):  # what it inherits counts as its own, wherever it is written
                if not member.startswith("_"):
                    found.setdefault(f"{name}.{member}", "member")
    return found


def main() -> None:
    """Print the names of the modules that the command line names."""
    warnings.simplefilter("ignore")
    result: dict[str, dict[str, str] | None] = {}
    for name in sys.argv[1:]:
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                result[name] = names(importlib.import_module(name))
        except BaseException as error:  # noqa: BLE001  whatever a module does when it is imported
            print(f"{name}: {type(error).__name__}: {error}", file=sys.stderr)
            result[name] = None
    print(json.dumps(result))


if __name__ == "__main__":
    main()
