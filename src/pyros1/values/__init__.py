"""Parameter values as YAML text: reading and writing as the ROS 1 tools do (https://wiki.ros.org/rosparam)."""

from __future__ import annotations

from typing import Any

from pyros1.values.reading import YamlError, load_all_yaml, load_yaml

__all__ = ["YamlError", "dump_yaml", "load_all_yaml", "load_yaml"]


def dump_yaml(value: Any) -> str:
    """Return a value as YAML 1.1 in the layout of the ROS 1 tools: one entry per line.

    Args:
        value: None, bool, int, float, str, bytes, date, datetime, and lists, tuples, dicts and sets of these.

    Returns:
        The text, keys sorted, ASCII only, ending in a newline; a bare plain scalar is followed by a line ``...``.

    Raises:
        YamlError: the value holds something that YAML cannot express, or contains itself.
    """
    from pyros1.values.writing import dump  # noqa: PLC0415 - most programs only read

    return dump(value, inline=lambda _: False)
