"""Makes the reference of all public names from their docstrings: ``python interop/reference.py [FOLDER]``.

It needs the extra ``docs``. FOLDER is ``dist/reference`` if it is not given. A warning is an error.

``python interop/reference.py --names`` prints the public names with their signatures instead, which CHANGELOG's
compatibility policy promises. A test compares them with ``interop/public_names.txt``, so that none changes unnoticed.
"""

from __future__ import annotations

import argparse
import importlib
import inspect
import re
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import get_type_hints

NAMES = (
    "pyros1",
    "pyros1.actions",
    "pyros1.aio",
    "pyros1.bag",
    "pyros1.diagnostics",
    "pyros1.filters",
    "pyros1.launch.scripting",
    "pyros1.msgs",
    "pyros1.reconfigure",
    "pyros1.testing",
    "pyros1.tf",
    "pyros1.tf.transformations",
)


def modules() -> list[ModuleType]:
    """Return the public modules, whose ``__all__`` are the public names. All of these are loaded."""
    found = [importlib.import_module(name) for name in NAMES]
    for module in found:
        for name in module.__all__:  # which most modules load when they are first used
            value = vars(module).setdefault(name, getattr(module, name))
            making = getattr(value, "__new__", None) if hasattr(value, "_fields") else None
            if hasattr(making, "__annotations__"):  # of a NamedTuple, whose types pdoc would look for in a wrong module
                making.__annotations__ = get_type_hints(value)
            if isinstance(value, type):
                _take_from_bases(value)
    return found


def _take_from_bases(value: type) -> None:
    """Make methods of a class's own bases, which have no page, its own."""
    for base in value.__mro__[1:]:
        if base.__module__.startswith("pyros1."):
            for name, member in vars(base).items():
                if not name.startswith("_") and name not in vars(value):
                    setattr(value, name, member)


def signatures() -> Iterator[str]:
    """Yield a line for each public name, parts of classes included: its full name, and its signature if it has one."""
    for module in modules():
        for name in sorted(module.__all__):
            value, full = getattr(module, name), f"{module.__name__}.{name}"
            yield full + _signature(value)
            if not inspect.isclass(value):
                continue
            for part, member in sorted(vars(value).items()):
                if not part.startswith("_") and (inspect.isroutine(member) or isinstance(member, property)):
                    yield f"{full}.{part}" + _signature(getattr(value, part))


def _signature(value: object) -> str:
    if inspect.ismodule(value) or not callable(value):
        return ""
    try:
        text = str(inspect.signature(value))
    except (TypeError, ValueError):  # of some exceptions
        return ""
    return re.sub(r"<\w+ .*? at 0x[0-9a-f]+>", "...", text)


def make(folder: Path) -> None:
    """Write the pages.

    Args:
        folder: where; it is made if need be.
    """
    import pdoc
    import pdoc.render

    modules()
    warnings.simplefilter("error")
    pdoc.render.configure(docformat="google", footer_text="pyros1")
    pdoc.pdoc(*(word for name in NAMES for word in (name, rf"!{name}\.")), output_directory=folder)


def run(make: Callable[[Path], None], usual: str, first: str) -> None:
    """Make pages in the folder that the command line names.

    Args:
        make: writes them into a folder.
        usual: the folder if none is named.
        first: the page that one opens first.
    """
    parser = argparse.ArgumentParser(description="Make pages from docstrings and the guide.")
    parser.add_argument("folder", type=Path, nargs="?", default=Path(usual), help=f"where to write them [{usual}]")
    folder = parser.parse_args().folder
    try:
        make(folder)
    except ModuleNotFoundError as error:
        sys.exit(f"{error}: pip install -e '.[docs]'")
    print(folder / first)


if __name__ == "__main__":
    if sys.argv[1:] == ["--names"]:
        print(*signatures(), sep="\n")
        sys.exit()
    run(make, "dist/reference", "pyros1.html")
