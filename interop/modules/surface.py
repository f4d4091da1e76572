"""The public names of Python modules and of their classes.

::

    python interop/modules/surface.py list MODULE...    # print them as JSON: {module: [name, "Class.member" ...]}
    python interop/modules/surface.py have < names      # the same, of such an answer, with what there is here only
    python interop/modules/surface.py modules PACKAGE...    # print all modules of packages: {package: [module ...]}

A name is public if the module lists it in ``__all__``, or if it begins without an underscore and belongs to the module:
what it has only because it imports it does not count, unless a package takes it from its own modules. A module that
cannot be imported has the value null.
"""

from __future__ import annotations

import contextlib
import functools
import importlib
import inspect
import io
import json
import os
import pkgutil
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


def below(name: str) -> list[str]:
    """Return the full names of a module and of those in it, without private and generated ones."""
    module = imported(name)
    found = [name]
    for each in pkgutil.iter_modules(getattr(module, "__path__", [])):
        if not each.name.startswith("_") and each.name not in ("msg", "srv", "cfg"):
            full = f"{name}.{each.name}"
            found += below(full) if each.ispkg else [full]
    return found


def has(module: Any, name: str) -> bool:
    """Tell whether a module has a name, or a class of it a member."""
    try:
        functools.reduce(getattr, name.split("."), module)
    except AttributeError:
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
    elif sys.argv[1] == "modules":
        result.update({name: below(name) for name in sys.argv[2:]})
    else:
        for name, wanted in json.load(sys.stdin).items():
            module = imported(name)
            result[name] = None if module is None else [each for each in wanted if has(module, each)]
    print(json.dumps(result))
    sys.stdout.flush()
    os._exit(0)  # libraries may have left threads


if __name__ == "__main__":
    main()
