"""The tool rosmsg-proto: an empty message as YAML, for the completion of command lines."""

from __future__ import annotations

import argparse
import sys
from collections import OrderedDict
from collections.abc import Iterator
from typing import Any

import yaml

from pyros1.ground.errors import Error
from pyros1.msgs import load_message, load_service

MAX_DEFAULT_NON_FLOW_ITEMS = 4
"""A message with more fields than this, or with a longer array, has its innermost parts in braces."""
_USAGE, _FAILED = 64, 1


class _Map(dict[str, Any]):
    """A message's fields; ``flow`` tells whether it is in braces: None means if it has only plain values."""

    flow: bool | None = None


class _List(list[Any]):
    """An array; ``flow`` as for `_Map`."""

    flow: bool | None = None


class _Dumper(yaml.SafeDumper):
    """Writes `_Map` and `_List`."""


_TAG = "tag:yaml.org,2002:"
_Dumper.add_representer(_Map, lambda self, value: self.represent_mapping(f"{_TAG}map", value.items(), value.flow))
_Dumper.add_representer(_List, lambda self, value: self.represent_sequence(f"{_TAG}seq", value, value.flow))


def _plain(value: Any) -> bool:
    return not isinstance(value, (_Map, _List))


def _set_flow(value: Any, style: int | None, big: bool = False) -> None:
    """Choose for a value, and all in it, whether it is in braces."""
    if _plain(value):
        return
    inner = list(value.values()) if isinstance(value, _Map) else value
    if isinstance(value, _Map):
        sizes = [len(value), *(len(each) for each in inner if isinstance(each, _List))]
        big = big or max(sizes) > MAX_DEFAULT_NON_FLOW_ITEMS
    value.flow = style == 1 if style is not None else big and all(_plain(each) for each in inner)
    for each in inner:
        _set_flow(each, style, big)


class _Maker:
    """Makes the values of an empty message.

    Args:
        excluded: names of fields to leave out.
        filled: whether an array of no fixed length gets an element.
    """

    def __init__(self, excluded: set[str], filled: bool) -> None:
        self._excluded = excluded
        self._filled = filled

    def message(self, cls: Any) -> _Map:
        """Return the fields of a message."""
        made = _Map()
        for name, kind, value in zip(
            cls.__slots__, cls._slot_types, [getattr(cls(), n) for n in cls.__slots__], strict=True
        ):
            if name not in self._excluded:
                made[name] = self._field(kind, value)
        return made

    def _field(self, kind: str, value: Any) -> Any:
        base, bracket, length = kind.partition("[")
        if not bracket:
            return self._one(base, value)
        if isinstance(value, (bytes, bytearray)):
            return bytes(value)
        if length != "]":
            return _List(self._one(base, each) for each in value)
        if not self._filled:
            return _List()
        return _List([self._element(base)])

    def _element(self, base: str) -> Any:
        if base == "string":
            return ""
        if base in ("time", "duration"):
            return _Map(secs=0, nsecs=0)
        return self.message(load_message(base)) if "/" in base else 0

    def _one(self, base: str, value: Any) -> Any:
        if base in ("time", "duration"):
            return _Map(secs=0, nsecs=0)
        if hasattr(value, "_slot_types"):
            return self.message(type(value))
        return value.item() if hasattr(value, "item") else value


def rosmsg_cmd_prototype(args: list[str]) -> str | None:
    """Return an empty message or request as YAML.

    Args:
        args: ``msg`` or ``srv``, options, and a type, with its package or without.

    Returns:
        The text, in quotes unless there is ``-H``; None if it failed and there is ``-s``.

    Raises:
        SystemExit: the words are wrong, 64; there is no such type, 1; an option is wrong, 2.
    """
    options = _options(args)
    if len(options.words) < 2 or options.words[0] not in ("msg", "srv"):
        _fail(options.silent, _USAGE, "Insufficient arguments")
        return None
    mode, name = options.words[:2]
    try:
        cls = _class(mode, name)
    except (Error, StopIteration):
        _fail(options.silent, _FAILED, f"Unknown {'message' if mode == 'msg' else 'service'} class: {name}")
        return None
    made = _Maker(set(options.excluded.split(",")), not options.empty).message(cls)
    _set_flow(made, options.flow)
    text: str = yaml.dump(made, Dumper=_Dumper, sort_keys=False).rstrip("\n")
    text = "\n".join(options.prefix + line for line in text.split("\n"))
    return text if options.bare else f'"{text}"'


def _options(args: list[str]) -> Any:
    parser = argparse.ArgumentParser("rosmsg-proto", description="Print an empty message or request as YAML.")
    parser.add_argument("words", nargs="*", metavar="msg|srv TYPE")
    parser.add_argument("-f", "--flow_style", "--flow-style", dest="flow", type=int, help="1: in braces, 0: in lines")
    parser.add_argument("-e", "--empty-arrays", dest="empty", action="store_true", help="no elements in arrays")
    parser.add_argument("-s", "--silent", action="store_true", help="no messages about errors")
    parser.add_argument("-p", "--prefix", default="", help="begin of each line")
    parser.add_argument("-H", "--no-hyphens", dest="bare", action="store_true", help="no quotes around it")
    parser.add_argument("-x", "--exclude-slots", dest="excluded", default="", help="fields to leave out: a,b")
    return parser.parse_intermixed_args(args)


def _fail(silent: bool, code: int, text: str) -> None:
    """Say what is wrong, and end the program; nothing of both if it is to be silent."""
    if not silent:
        sys.stderr.write(text)
        sys.exit(code)


def _class(mode: str, name: str) -> Any:
    """Return the class of a message, or of a service's request; raises Error or StopIteration without one."""
    if "/" not in name:
        import rosmsg

        name = next(iter(rosmsg.rosmsg_search(None, f".{mode}", name)))
    return load_message(name) if mode == "msg" else load_service(name)._request_class


# YAML in the order of the fields ------------------------------------------------------------------------------------


def represent_ordered_mapping(self: Any, tag: str, mapping: Any, flow_style: bool | None = None) -> Any:
    """Return the YAML node of a mapping, in its own order.

    Args:
        self: a yaml.Dumper.
        tag: of the node.
        mapping: a dict, or pairs.
        flow_style: whether it is in braces; None: as the dumper does it.
    """
    pairs = list(mapping.items()) if hasattr(mapping, "items") else list(mapping)  # the dumper would sort a dict
    return self.represent_mapping(tag, pairs, flow_style)


def construct_ordered_mapping(self: Any, node: Any, deep: bool = False) -> OrderedDict[Any, Any]:
    """Return the OrderedDict of a YAML node; ``self`` is a yaml.Loader, ``deep`` as in PyYAML.

    Raises:
        yaml.constructor.ConstructorError: the node is no mapping.
    """
    if not isinstance(node, yaml.MappingNode):
        raise yaml.constructor.ConstructorError(
            None, None, f"expected a mapping node, but found {node.id}", node.start_mark
        )
    return OrderedDict(
        (self.construct_object(key, deep=True), self.construct_object(value, deep=deep)) for key, value in node.value
    )


def construct_yaml_map_with_ordered_dict(self: Any, node: Any) -> Iterator[OrderedDict[Any, Any]]:
    """Yield the OrderedDict of a YAML node, and fill it then, so that it may contain itself."""
    made: OrderedDict[Any, Any] = OrderedDict()
    yield made
    made.update(construct_ordered_mapping(self, node))


def init_rosmsg_proto() -> None:
    """Let ``yaml.dump`` write an OrderedDict in its order, as a mapping."""
    yaml.add_representer(OrderedDict, lambda dumper, value: represent_ordered_mapping(dumper, f"{_TAG}map", value))
