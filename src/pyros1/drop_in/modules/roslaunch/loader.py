"""Errors of reading launches, and the base of what reads them."""

from __future__ import annotations

from typing import Any

from pyros1.drop_in.missing import missing
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


__getattr__ = missing(
    "roslaunch.loader",
    LoaderContext="launch files are read by pyros1.launch.reading",
    load_mappings="launch files are read by pyros1.launch.reading",
    load_sysargs_into_context="launch files are read by pyros1.launch.reading",
    post_process_include_args="launch files are read by pyros1.launch.reading",
    process_include_args="launch files are read by pyros1.launch.reading",
    rosparam="launch files are read by pyros1.launch.reading",
    PRIV_NAME="launch files are read by pyros1.launch.reading",
)
