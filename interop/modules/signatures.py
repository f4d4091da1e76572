"""Print the parameters of public functions, classes and methods of Python modules as JSON: on stock's modules and ours.

::

    python interop/modules/signatures.py MODULE...

The answer is ``{module: {name: [[parameter, kind, whether it has a default], ...]}}``. Names with one underscore in
front do not count, but ``__init__`` and ``__call__`` do.
"""

from __future__ import annotations

import importlib
import inspect
import json
import sys
import types
import warnings
from typing import Any

HOMES = {"rospy", "genpy", "pyros1", "rosgraph"}


def parameters(value: Any) -> list[Any] | None:
    """Return the parameters of a function; None if Python does not know them."""
    try:
        found = inspect.signature(value).parameters.values()
    except (TypeError, ValueError):
        return None
    return [
        [each.name, each.kind.name, each.default is not each.empty]
        for each in found
        if each.name not in ("self", "cls")
    ]


def signatures(module: types.ModuleType) -> dict[str, Any]:
    """Return the parameters of what a module holds."""
    found: dict[str, Any] = {}
    for name in dir(module):
        value = getattr(module, name, None)
        home = str(getattr(value, "__module__", ""))
        if name.startswith("_") or isinstance(value, types.ModuleType) or home.partition(".")[0] not in HOMES:
            continue
        if inspect.isclass(value):
            for member in dir(value):
                method = getattr(value, member, None)
                if (not member.startswith("_") or member in ("__init__", "__call__")) and inspect.isroutine(method):
                    found[f"{name}.{member}"] = parameters(method)
        elif callable(value):
            found[name] = parameters(value)
    return {name: each for name, each in found.items() if each is not None}


def main() -> None:
    """Print the signatures of the modules that the command line names."""
    warnings.simplefilter("ignore")
    print(json.dumps({name: signatures(importlib.import_module(name)) for name in sys.argv[1:]}))


if __name__ == "__main__":
    main()
