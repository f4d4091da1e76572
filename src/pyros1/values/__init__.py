"""Reads and writes parameter values as YAML, like the ROS 1 tools (https://wiki.ros.org/rosparam)."""

from __future__ import annotations

from typing import Any

from pyros1.values.reading import YamlError, load_all_yaml, load_yaml

__all__ = ["YamlError", "dump_yaml", "load_all_yaml", "load_yaml"]


def dump_yaml(value: Any) -> str:
    """Return a value as YAML 1.1 in the layout of the ROS 1 tools, with one entry per line.

    Args:
        value: None, bool, int, float, str, bytes, date, datetime, or lists, tuples, dicts and sets of these.

    Returns:
        The YAML text with sorted keys, ASCII only, ending in a newline; a single plain scalar is followed by a line
        ``...``.

    Raises:
        YamlError: the value contains something that YAML cannot express, or contains itself.
    """
    from pyros1.values.writing import dump  # noqa: PLC0415 - most programs only read

    return dump(value, is_inline=lambda _: False)
