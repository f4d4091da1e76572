"""Loads the modules that define a package's public names when these names are first used (PEP 562)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

_ANNOTATION_NAMES = {"Any", "TYPE_CHECKING", "annotations"}
"""Names that a package imports for its own annotations."""


def import_without_lock(name: str) -> Any:
    """Import a module as an import statement does, and return it. The module is usually loaded already.

    Before Python 3.11, `importlib.import_module` always acquires the module's lock, and a signal handler that does so
    while the main thread holds the lock deadlocks.

    Args:
        name: the module's full name.

    Raises:
        ImportError: there is no such module.
    """
    return __import__(name, fromlist=("__name__",))  # without `fromlist`, the outermost package would be returned


def load(package: str, exports: Mapping[str, str], name: str) -> Any:
    """Return the value of a public name of a package, importing its module; for the package's ``__getattr__``.

    Args:
        package: the package's full name.
        exports: public name -> full name of the module that defines it.
        name: the public name.

    Raises:
        AttributeError: the package has no such name.
    """
    module_name = exports.get(name)
    if module_name is None:
        raise AttributeError(f"module {package!r} has no attribute {name!r}")
    return getattr(import_without_lock(module_name), name)


def public_names(names: Iterable[str], public: Iterable[str]) -> list[str]:
    """Return the names that `dir` lists; for the package's ``__dir__``.

    Args:
        names: the names currently defined in the package.
        public: all public names, loaded or not.
    """
    return sorted(({*names} - _ANNOTATION_NAMES) | {*public})
