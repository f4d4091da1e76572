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
from pyros1.observe.template import LONG, template

MAX_DEFAULT_NON_FLOW_ITEMS = LONG
_USAGE, _FAILED = 64, 1
_TAG = "tag:yaml.org,2002:"


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
    text = template(cls, options.flow, empty_arrays=options.empty, excluded=options.excluded.split(","))
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
    """Print what is wrong and exit; do neither if ``silent``."""
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
