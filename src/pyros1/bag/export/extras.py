"""Imports optional packages that only some exports need."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from pyros1.ground.errors import Error


def import_extra(module: str, extra: str) -> Any:
    """Import and return a module from an optional package.

    Args:
        module: for example ``PIL.Image``.
        extra: name of the pyros1 extra that installs it.

    Raises:
        Error: the package is not installed; the message says how to install it.
    """
    try:
        return import_module(module)
    except ImportError as error:
        raise Error(f"this needs {module.partition('.')[0]} ({error}): pip install 'pyros1[{extra}]'") from None
