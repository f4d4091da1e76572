"""Makes ``__getattr__`` functions for names that a module imports lazily, or lacks (errors give the reason)."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.util import find_spec
from typing import Any

# fmt: off
_IMPORTED_MODULES = frozenset((
    "atexit", "codecs", "errno", "functools", "genpy", "inspect", "io", "itertools", "keyword", "logging", "math",
    "os", "pickle", "random", "re", "rosgraph", "roslib", "rospkg", "rospy", "select", "shutil", "socket", "struct",
    "sys", "tempfile", "threading", "time", "traceback", "types", "warnings", "yaml",
))
# fmt: on
"""Modules that stock's modules import, and that programs access through them."""


def module_hooks(
    module: str,
    lazy_imports: Mapping[str, str] | None = None,
    missing_reasons: Mapping[str, str] | None = None,
    computed_values: Mapping[str, Callable[[], Any]] | None = None,
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return a ``__getattr__`` and a ``__dir__`` for a module.

    Args:
        module: the module's full name.
        lazy_imports: name -> full name of the module from which to import the name. With a trailing dot, the name
            stands for that module itself.
        missing_reasons: name that pyros1 does not have -> the reason, or what to use instead.
        computed_values: variable in stock's module -> function that returns the variable's current value.
    """
    source_modules = lazy_imports or {}
    values = computed_values or {}

    def __getattr__(name: str) -> Any:
        if name in values:
            return values[name]()
        source_module = source_modules.get(name)
        if source_module is None:
            if name.startswith("__"):
                raise AttributeError(f"module {module!r} has no attribute {name!r}")
            if _is_module(f"{module}.{name}"):  # stock's modules import each other, and programs rely on that
                return import_module(f"{module}.{name}")
            if name in _IMPORTED_MODULES:
                return import_module(name)
            reason = (missing_reasons or {}).get(name, "")
            raise AttributeError(f"pyros1 has no {module}.{name}{reason and ': ' + reason}")
        return (
            import_module(source_module[:-1])
            if source_module.endswith(".")
            else getattr(import_module(source_module), name)
        )

    def __dir__() -> list[str]:
        return sorted({*vars(sys.modules[module]), *source_modules})

    return __getattr__, __dir__


def _is_module(name: str) -> bool:
    try:
        return find_spec(name) is not None
    except (ImportError, ValueError):  # the finder reports the reason; ValueError: a program has replaced the module
        return False


def class_getattr(owner: str, reason: str, missing_names: frozenset[str]) -> Callable[[Any, str], Any]:
    """Return a ``__getattr__`` for a class that lacks members of stock's class.

    Args:
        owner: the expression with which programs access the class's objects, for example ``Publisher.impl``.
        reason: why some members are missing.
        missing_names: the names of these members.
    """

    def __getattr__(self: Any, name: str) -> Any:
        if name in missing_names:
            raise AttributeError(f"pyros1 has no {owner}.{name}: {reason}")
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    return __getattr__


def module_getattr(module: str, **reasons: str) -> Callable[[str], Any]:
    """Return a ``__getattr__`` for a module that imports nothing lazily.

    Args:
        module: the module's full name.
        **reasons: for names that programs may use, why they are missing, or what to use instead.
    """
    return module_hooks(module, missing_reasons=reasons)[0]
