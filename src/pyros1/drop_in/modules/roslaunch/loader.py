"""Converts parameter values in launch files; pyros1.launch.reading reads the files."""

from __future__ import annotations

from typing import Any

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.ground.errors import LaunchError
from pyros1.launch.reading.convert import convert_value as _convert
from roslaunch.core import RLException

_READING = "pyros1.launch.reading reads launch files; see XmlLoader.load and ROSLaunchConfig.add_param"


class LoadException(RLException):
    """A launch file cannot be read."""


def convert_value(value: str, type_: str) -> Any:
    """Convert the text of a parameter to its value.

    Args:
        value: the text.
        type_: "str", "int", "double", "bool", "auto" or "yaml".

    Raises:
        ValueError: the text cannot be converted to that type.
    """
    try:
        return _convert(value, type_.lower())
    except LaunchError as error:
        cause = error.__cause__
        raise ValueError(str(cause if isinstance(cause, ValueError) else error)) from error


__getattr__ = module_getattr(
    "roslaunch.loader",
    Loader=_READING,
    LoaderContext=_READING,
    load_mappings=_READING,
    load_sysargs_into_context=_READING,
    post_process_include_args=_READING,
    process_include_args=_READING,
    rosparam=_READING,
)
