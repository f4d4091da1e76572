"""Values to YAML text, in PyYAML's layout, which scripts around the ROS 1 tools expect.

Added here: the choice of what is written in brackets, quotation marks for strings that look like angles, and numpy's
numbers; PyYAML leaves all of these to its users.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from typing import Any

from pyros1.values.reading import ANGLES, YamlError, simple_value


def dump(value: Any, *, inline: Callable[[Any], bool], ordered: bool = False) -> str:
    """Return the text of a value.

    Args:
        value: see `pyros1.values.dump_yaml`.
        inline: returns whether a list or dict is written in brackets; then everything inside it is as well.
        ordered: dicts keep their order; otherwise their keys are sorted.

    Raises:
        YamlError: see `pyros1.values.dump_yaml`.
    """
    if value.__class__ in (str, int, float):
        text = str(value)
        if simple_value(text) == value:
            return f"{text}\n...\n"
    import yaml  # noqa: PLC0415 - slow to import, and most parameters are one word or number

    dumper = _dumper_class()
    try:
        return str(yaml.dump(value, Dumper=lambda *args, **kwds: dumper(inline, ordered, *args, **kwds)))
    except yaml.YAMLError as error:
        raise YamlError(f"cannot write as YAML: {' '.join(map(str, error.args))}") from error
    except RecursionError as error:
        raise YamlError("cannot write as YAML: nested too deeply, or a value contains itself") from error


@cache
def _dumper_class() -> Any:
    import yaml  # noqa: PLC0415

    class Dumper(yaml.SafeDumper):
        def __init__(self, inline: Callable[[Any], bool], ordered: bool, *args: Any, **kwds: Any) -> None:
            super().__init__(*args, **kwds)
            self._inline = inline
            self._ordered = ordered

        def ignore_aliases(self, data: Any) -> bool:
            return True  # no aliases: a value is written wherever it is used

        def represent_mapping(self, tag: str, mapping: Any, flow_style: bool | None = None) -> Any:
            pairs: Iterable[Any] = mapping
            if self._ordered and isinstance(mapping, dict):
                pairs = [*mapping.items()]  # items given as a list are not sorted
            return super().represent_mapping(tag, pairs, flow_style=self._inline(mapping))

        def represent_sequence(self, tag: str, sequence: Any, flow_style: bool | None = None) -> Any:
            return super().represent_sequence(tag, sequence, flow_style=self._inline(sequence))

    for tag, (pattern, first) in ANGLES.items():  # texts that look like angles get quotation marks
        Dumper.add_implicit_resolver(tag, pattern, [first])
    for kind in (dict, list, tuple, set, str, bytes, int, float):  # and subclasses, such as numpy's numbers
        Dumper.add_multi_representer(kind, _represent_as(kind))
    Dumper.add_multi_representer(bytearray, lambda dumper, data: dumper.represent_data(bytes(data)))
    return Dumper


def _represent_as(kind: Any) -> Callable[[Any, Any], Any]:
    return lambda dumper, data: dumper.yaml_representers[kind](dumper, kind(data))
