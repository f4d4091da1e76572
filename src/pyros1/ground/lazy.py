"""Public names of a package whose modules are loaded when they are first used (PEP 562)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

_HELPERS = {"Any", "TYPE_CHECKING", "annotations"}
"""Names that a package imports for its own annotations."""


def module(name: str) -> Any:
    """Import a module that is usually loaded already, as an import statement does.

    `importlib.import_module` takes the module's lock each time before Python 3.11, and a signal handler that does so
    while the main thread does waits forever.

    Args:
        name: the module's full name.

    Raises:
        ImportError: there is no such module.
    """
    return __import__(name, fromlist=("__name__",))  # with a name, since the outermost package is returned otherwise


def load(package: str, exports: Mapping[str, str], name: str) -> Any:
    """Return a public name of a package, for the package's ``__getattr__``.

    Args:
        package: the package's full name.
        exports: public name -> full name of its module.
        name: the public name.

    Raises:
        AttributeError: the package has no such name.
    """
    home = exports.get(name)
    if home is None:
        raise AttributeError(f"module {package!r} has no attribute {name!r}")
    return getattr(module(home), name)


def listing(names: Iterable[str], public: Iterable[str]) -> list[str]:
    """Return the names to list, for the package's ``__dir__``.

    Args:
        names: the names that the package has now.
        public: all public names, loaded or not.
    """
    return sorted(({*names} - _HELPERS) | {*public})
