"""Errors of reading launches, and the base of what reads them."""

from __future__ import annotations

from typing import Any

from pyros1.launch.reading.convert import convert_value as _convert
from roslaunch.core import RLException


class LoadException(RLException):
    """Something in a launch cannot be read."""


class Loader:
    """Base of XmlLoader."""


def convert_value(value: str, type_: str) -> Any:
    """Return a parameter's value from its text.

    Args:
        value: the text.
        type_: "str", "int", "double", "bool", "auto" or "yaml".

    Raises:
        ValueError: the text has another type.
    """
    return _convert(value, type_.lower())


def __getattr__(name: str) -> Any:
    if name in ("LoaderContext", "load_mappings", "load_sysargs_into_context", "process_include_args"):
        raise AttributeError(f"pyros1 has no roslaunch.loader.{name}: launch files are read by pyros1.launch.reading")
    raise AttributeError(f"module 'roslaunch.loader' has no attribute {name!r}")
