"""Writes values as YAML in PyYAML's layout, which scripts that use the ROS 1 tools expect.

This adds to PyYAML: the choice of what is written in brackets, quotes around strings that look like angles, and numpy
numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from typing import Any

from pyros1.values.reading import ANGLE_TAGS, YamlError, parse_simple_value


def dump(value: Any, *, is_inline: Callable[[Any], bool], ordered: bool = False) -> str:
    """Return a value as YAML.

    Args:
        value: see `pyros1.values.dump_yaml`.
        is_inline: returns whether to write a list or dict, and everything inside it, in brackets.
        ordered: whether to keep the order of dicts instead of sorting their keys.

    Raises:
        YamlError: see `pyros1.values.dump_yaml`.
    """
    if value.__class__ in (str, int, float):
        text = str(value)
        if parse_simple_value(text) == value:
            return f"{text}\n...\n"
    import yaml  # noqa: PLC0415 - slow to import, and most parameters are single words or numbers

    dumper = _dumper_class()
    try:
        return str(yaml.dump(value, Dumper=lambda *args, **kwds: dumper(is_inline, ordered, *args, **kwds)))
    except yaml.YAMLError as error:
        raise YamlError(f"cannot write as YAML: {' '.join(map(str, error.args))}") from error
    except RecursionError as error:
        raise YamlError("cannot write as YAML: nested too deeply, or a value contains itself") from error


@cache
def _dumper_class() -> Any:
    import yaml  # noqa: PLC0415

    class Dumper(yaml.SafeDumper):
        def __init__(self, is_inline: Callable[[Any], bool], ordered: bool, *args: Any, **kwds: Any) -> None:
            super().__init__(*args, **kwds)
            self._is_inline = is_inline
            self._ordered = ordered

        def ignore_aliases(self, data: Any) -> bool:
            return True  # no aliases: a value is written wherever it occurs

        def represent_mapping(self, tag: str, mapping: Any, flow_style: bool | None = None) -> Any:
            pairs: Iterable[Any] = mapping
            if self._ordered and isinstance(mapping, dict):
                pairs = [*mapping.items()]  # items given as a list are not sorted
            return super().represent_mapping(tag, pairs, flow_style=self._is_inline(mapping))

        def represent_sequence(self, tag: str, sequence: Any, flow_style: bool | None = None) -> Any:
            return super().represent_sequence(tag, sequence, flow_style=self._is_inline(sequence))

    for tag, (pattern, first_character) in ANGLE_TAGS.items():  # strings that look like angles are quoted
        Dumper.add_implicit_resolver(tag, pattern, [first_character])
    for value_type in (dict, list, tuple, set, str, bytes, int, float):  # subclasses, too, such as numpy numbers
        Dumper.add_multi_representer(value_type, _make_representer(value_type))
    Dumper.add_multi_representer(bytearray, lambda dumper, data: dumper.represent_data(bytes(data)))
    return Dumper


def _make_representer(value_type: Any) -> Callable[[Any, Any], Any]:
    return lambda dumper, data: dumper.yaml_representers[value_type](dumper, value_type(data))
