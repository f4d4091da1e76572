"""``pyros1 topic_tools transform`` and ``relay_field``: messages made from messages by expressions (L193)."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pyros1 import names
from pyros1.cli.common import CommandError
from pyros1.cli.shared.expression import is_function
from pyros1.cli.shared.fields import FieldPath, FieldPathError
from pyros1.cli.shared.subscribing import Decoder
from pyros1.cli.topic_tools import open_node
from pyros1.cli.topic_tools_expression import (
    MessageExpression,
    ModuleError,
    load_modules,
    names_used,
)
from pyros1.cli.usage import examples_text
from pyros1.errors import Error, MessageError
from pyros1.expressions import ExpressionError
from pyros1.graph import Graph
from pyros1.msgs import AnyMsg, Message, load_message
from pyros1.msgs.fill import fill_message
from pyros1.node import Node
from pyros1.timing import Time
from pyros1.topic_tools.output import QUEUE_SIZE
from pyros1.values import load_yaml

Make = Callable[[Any], list[Any]]
"""Makes the values to publish of a message or field."""

_LOOK_AGAIN = 0.2
_ABOUT = {
    "transform": "Publishes what an expression makes of each message m of a topic, or of a field of it.\n"
    "A list or tuple stands for the fields of the output, in order.",
    "relay_field": "Publishes a message whose fields are given as YAML. Texts in it that are\n"
    "expressions with known names are calculated from the message m of a topic, or of a field of it.",
}
_EXAMPLES = {
    "transform": {
        "%prog /imu/orientation/x /degrees std_msgs/Float64 -- '-numpy.rad2deg(m)'": "",
        "%prog /imu/orientation /norm std_msgs/Float64 'numpy.linalg.norm([m.x, m.y, m.z, m.w])'": "",
        "%prog /odom /pose geometry_msgs/PoseStamped '[m.header, m.pose.pose]'": "",
    },
    "relay_field": {"%prog /chatter /header std_msgs/Header 'stamp: now\nframe_id: m.data'": ""},
}


def main(tool: str, words: Sequence[str]) -> int:
    """Run one of the two tools until its node ends.

    Args:
        tool: ``transform`` or ``relay_field``.
        words: its arguments, remappings among them.

    Returns:
        The exit code: 2 after wrong usage, 1 if a topic, type, module or expression is not there or wrong.
    """
    parser = _parser(tool)
    try:
        options = parser.parse_args(names.parse_arguments(list(words)).rest)
    except SystemExit as end:  # argparse has printed help or what is wrong
        return int(end.code or 0)
    remappings = [word for word in words if word not in names.parse_arguments(list(words)).rest]
    try:
        output_class = load_message(options.output_type)
        with open_node(tool, remappings) as node:
            modules = load_modules(getattr(options, "modules", ()), node.now)
            if tool == "transform":
                make = _transformer(options.expression, modules)
            else:
                make = _filler(options.expression, modules, output_class, node.now)
            _Transform(node, options, output_class, make).run()
    except (CommandError, ExpressionError, MessageError, ModuleError, ValueError) as error:
        print(f"ERROR: {error}", file=sys.stderr)
        return 1
    return 0


def _parser(tool: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=tool,
        description=_ABOUT[tool],
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=examples_text(f"pyros1 topic_tools {tool}", _EXAMPLES[tool]),
    )
    parser.add_argument("input", help="input topic, or a field of it: /topic/field")
    parser.add_argument("output_topic", help="output topic")
    parser.add_argument("output_type", help="its type")
    if tool == "transform":
        parser.add_argument("expression", nargs="?", default="m", help="of the message m; by default m itself")
        parser.add_argument(
            "-i",
            "--import",
            dest="modules",
            nargs="+",
            default=[],
            help="rospy, tf or packages of messages; math and numpy are there without",
        )
        parser.add_argument("--latch", action="store_true", help="latch the output")
    else:
        parser.add_argument("expression", help="the output's fields, as YAML")
    parser.add_argument("--wait-for-start", action="store_true", help="wait for the input topic")
    parser.add_argument("--tcpnodelay", action="store_true", help="for compatibility: it is always so")
    return parser


class _Transform:
    """The node: decodes, picks the field, lets ``make`` make values of it, publishes them."""

    def __init__(self, node: Node, options: argparse.Namespace, output_class: type[Message], make: Make) -> None:
        self._node = node
        self._make = make
        self._decoder = Decoder()
        topic, self._path = _find(node, options.input, bool(options.wait_for_start))
        latch = bool(getattr(options, "latch", False))
        self._publisher: Any = node.advertise(options.output_topic, output_class, queue_size=QUEUE_SIZE, latch=latch)
        node.log.info("from %s to %s", options.input, options.output_topic)
        node.subscribe(topic, AnyMsg, self._receive, queue_size=QUEUE_SIZE)

    def run(self) -> None:
        self._node.spin()

    def _receive(self, raw: AnyMsg) -> None:
        try:
            message, _ = self._path.get(self._decoder.decode(raw))
            self._publisher.publish(*self._make(message))
        except (Error, TypeError, AttributeError) as error:
            self._node.log.error("%s", error, throttle=1.0)


def _find(node: Node, name: str, wait: bool) -> tuple[str, FieldPath]:
    """Split the input into topic and field.

    Raises:
        CommandError: there is no such topic, and we are not to wait for it.
    """
    full = names.ns_join(node.namespace, name)
    graph = Graph(node.master)
    found = graph.find_topic(full)
    while found is None and wait and node.sleep(_LOOK_AGAIN):
        found = graph.find_topic(full)
    if found is None:
        raise CommandError(f"Wrong input topic (or topic field): {full}")
    try:
        return found[0], FieldPath(found[2])
    except FieldPathError as error:
        raise CommandError(f"Wrong input topic (or topic field): {full}: {error}") from None


def _fields(text: str, modules: Mapping[str, Any]) -> dict[str, Any]:
    """Return the output's fields, with expressions in place of the texts that are some.

    Raises:
        CommandError: it is not YAML of fields.
        ExpressionError: an expression uses what is not allowed.
    """
    fields = load_yaml(text)
    if not isinstance(fields, dict):
        raise CommandError(f"the output's fields must be given as YAML, such as 'data: m.data', not {text!r}")
    return _with_expressions(fields, modules)


def _with_expressions(fields: Mapping[str, Any], modules: Mapping[str, Any]) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for name, value in fields.items():
        result[name] = value
        if isinstance(value, dict):
            result[name] = _with_expressions(value, modules)
        elif isinstance(value, str) and _is_expression(value, modules):
            result[name] = MessageExpression(value)
    return result


def _is_expression(text: str, modules: Mapping[str, Any]) -> bool:
    """Whether a text is Python of which all names are known: so map or base_link are frames, m.data is none."""
    try:
        used = names_used(text)
    except (SyntaxError, ValueError):
        return False
    return used != {text.strip()} - {"m"} and all(name == "m" or name in modules or is_function(name) for name in used)


def _evaluated(fields: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for name, value in fields.items():
        if isinstance(value, MessageExpression):
            result[name] = value.evaluate(values)
        else:
            result[name] = _evaluated(value, values) if isinstance(value, dict) else value
    return result


def _transformer(text: str, modules: Mapping[str, Any]) -> Make:
    expression = MessageExpression(text)
    for name in sorted(names_used(text) - {"m"}):
        expression.name(name, {**modules, "m": None})  # raises if there is no such name

    def make(message: Any) -> list[Any]:
        result = expression.evaluate({**modules, "m": message})
        return list(result) if isinstance(result, (list, tuple)) else [result]

    return make


def _filler(text: str, modules: Mapping[str, Any], output_class: type[Message], now: Callable[[], Time]) -> Make:
    fields = _fields(text, modules)

    def make(message: Any) -> list[Any]:
        result = output_class()
        fill_message(result, _evaluated(fields, {**modules, "m": message}), now())
        return [result]

    return make
