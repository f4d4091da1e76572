"""Public names of a package whose modules are loaded when they are first used (PEP 562)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from importlib import import_module
from typing import Any

_HELPERS = {"Any", "TYPE_CHECKING", "annotations"}
"""Names that a package imports for its own annotations."""


def load(package: str, homes: Mapping[str, str], name: str) -> Any:
    """Return a public name of a package, for the package's ``__getattr__``.

    Args:
        package: the package's full name.
        homes: public name -> full name of its module.
        name: the public name.

    Raises:
        AttributeError: the package has no such name.
    """
    home = homes.get(name)
    if home is None:
        raise AttributeError(f"module {package!r} has no attribute {name!r}")
    return getattr(import_module(home), name)


def listing(names: Iterable[str], public: Iterable[str]) -> list[str]:
    """Return the names to list, for the package's ``__dir__``.

    Args:
        names: what the package holds now.
        public: all public names, loaded or not.
    """
    return sorted(({*names} - _HELPERS) | {*public})
