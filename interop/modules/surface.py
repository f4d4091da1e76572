"""The public names of Python modules and of their classes.

::

    python interop/modules/surface.py list MODULE...    # print them as JSON: {module: [name, "Class.member" ...]}
    python interop/modules/surface.py have < names      # the same, of such an answer, with what there is here only

A name is public if the module lists it in ``__all__``, or if it begins without an underscore and belongs to the module:
what it has only because it imports it does not count, unless a package takes it from its own modules. A module that
cannot be imported has the value null.
"""

from __future__ import annotations

import contextlib
import importlib
import inspect
import io
import json
import os
import sys
import types
import warnings
from collections.abc import Iterable
from typing import Any

FOREIGN = {*sys.stdlib_module_names, "numpy", "yaml", "defusedxml", "catkin_pkg", "builtins"}


def belongs(module: str, value: object) -> bool:
    """Tell whether a value is of a module, as far as one can see."""
    if isinstance(value, types.ModuleType) or type(value).__module__ == "__future__":
        return False
    home = getattr(value, "__module__", None) if callable(value) else None
    if home is None:
        return type(value).__module__ == "builtins" or type(value).__module__.partition(".")[0] not in FOREIGN
    top = home.partition(".")[0].lstrip("_")
    return home == module or ("." not in module and bool(top) and module.startswith(top))  # _tf2 belongs to tf2_py


def names(module: types.ModuleType) -> list[str]:
    """Return the public names of a module, and of its classes."""
    listed: Iterable[str] | None = getattr(module, "__all__", None)
    found: list[str] = []
    for name in sorted({*(listed or dir(module))}):
        value = getattr(module, name, None)
        if isinstance(value, types.ModuleType):
            continue
        if listed is None and (name.startswith("_") or not belongs(module.__name__, value)):
            continue
        found.append(name)
        if inspect.isclass(value) and not issubclass(value, (BaseException, tuple)):
            found += [f"{name}.{member}" for member in members(value)]
    return found


def members(cls: type) -> list[str]:
    """Return the public attributes of a class that come from ROS's own classes."""
    own = [each for each in cls.__mro__ if each.__module__.partition(".")[0] not in FOREIGN]
    return sorted({name for each in own for name in vars(each) if not name.startswith("_")})


def imported(name: str) -> Any:
    """Return a module; None with a word on stderr if it cannot be imported, whatever it does."""
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            return importlib.import_module(name)
    except BaseException as error:  # noqa: BLE001
        print(f"{name}: {type(error).__name__}: {error}", file=sys.stderr)
        return None


def has(module: Any, name: str) -> bool:
    """Return whether a module has a name, or a class or module in it."""
    path, value = module.__name__, module
    for part in name.split("."):
        path += f".{part}"
        try:
            value = getattr(value, part)
        except AttributeError:
            value = imported(path)
            if value is None:
                return False
    return True


def main() -> None:
    """Print what the command line asks for."""
    warnings.simplefilter("ignore")
    result: dict[str, list[str] | None] = {}
    if sys.argv[1] == "list":
        for name in sys.argv[2:]:
            module = imported(name)
            result[name] = None if module is None else names(module)
    else:
        for name, wanted in json.load(sys.stdin).items():
            module = imported(name)
            result[name] = None if module is None else [each for each in wanted if has(module, each)]
    print(json.dumps(result))
    sys.stdout.flush()
    os._exit(0)  # libraries may have left threads


if __name__ == "__main__":
    main()
