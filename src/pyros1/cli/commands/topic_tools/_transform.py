"""Shared code of ``transform`` and ``relay_field``, which compute messages from received ones (L193)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.cli.commands.topic_tools._expression import load_modules
from pyros1.cli.commands.topic_tools._tool import open_node
from pyros1.cli.failures import CommandError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Verb
from pyros1.cli.shared.argparsing import add_options_and_arguments, make_parser
from pyros1.graph import Graph
from pyros1.ground import names
from pyros1.ground.errors import Error
from pyros1.msgs import AnyMsg, Message, load_message
from pyros1.observe.decoder import Decoder
from pyros1.observe.fields import FieldPath, FieldPathError

if TYPE_CHECKING:
    from pyros1.node import Node

TRANSFORM_ARGUMENTS = (
    Argument("input", "topic", help="input topic, or a field of its messages: /topic/field"),
    Argument("output_topic", "topic", help="output topic"),
    Argument("output_type", "message_type", help="type of the output topic"),
)
TRANSFORM_OPTIONS = (
    Flag("--wait-for-start", help="wait for the input topic"),
    Flag("--tcpnodelay", help="accepted for compatibility; no effect"),
)
Evaluator = Callable[[Any], list[Any]]
"""Returns the values of the output message's fields for an input message or field."""
EvaluatorFactory = Callable[[Mapping[str, Any], type[Message], "Node"], Evaluator]
"""Creates an evaluator from the modules by name, the output's type, and the node."""

_POLL_PERIOD = 0.2


def parse_with_argparse(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Parse the arguments of a verb with argparse, as in stock ROS, so that an option can have several values.

    Returns:
        The values of options and arguments by name, and an empty list.

    Raises:
        SystemExit: help (code 0) or a usage error (code 2) was printed.
    """
    parser = make_parser(invocation, verb)
    parser.prog = verb.name
    add_options_and_arguments(parser, invocation, *verb.arguments, *verb.options)
    return parser.parse_args(invocation.args), []


def publish_evaluated(invocation: Invocation, tool: str, options: Any, make_evaluator: EvaluatorFactory) -> None:
    """For each received message, publish a message created by the evaluator, until the node shuts down."""
    try:
        output_class = load_message(options.output_type)
        with open_node(invocation, tool) as node:
            modules = load_modules(getattr(options, "modules", ()), node.now)
            _Transform(node, options, output_class, make_evaluator(modules, output_class, node)).run()
    except ValueError as error:
        raise CommandError(str(error)) from error


class _Transform:
    """Decodes messages, evaluates the expression on the selected field, and publishes the values."""

    def __init__(self, node: Node, options: Any, output_class: type[Message], evaluate: Evaluator) -> None:
        from pyros1.topic_tools.output import QUEUE_SIZE  # noqa: PLC0415 - not needed for help

        self._node = node
        self._evaluate = evaluate
        self._decoder = Decoder()
        topic, self._path = _find_input(node, options.input, bool(options.wait_for_start))
        latch = bool(getattr(options, "latch", False))
        self._publisher: Any = node.advertise(options.output_topic, output_class, queue_size=QUEUE_SIZE, latch=latch)
        node.log.info("from %s to %s", options.input, options.output_topic)
        node.subscribe(topic, AnyMsg, self._receive, queue_size=QUEUE_SIZE)

    def run(self) -> None:
        self._node.spin()

    def _receive(self, raw: AnyMsg) -> None:
        try:
            message, _ = self._path.get(self._decoder.decode(raw))
            self._publisher.publish(*self._evaluate(message))
        except (Error, TypeError, AttributeError) as error:
            self._node.log.error("%s", error, throttle=1.0)


def _find_input(node: Node, name: str, waits: bool) -> tuple[str, FieldPath]:
    """Split the input into a topic and a field path.

    Raises:
        CommandError: the topic does not exist, and ``--wait-for-start`` is not given.
    """
    full_name = names.ns_join(node.namespace, name)
    graph = Graph(node.master)
    topic_match = graph.find_topic(full_name)
    while topic_match is None and waits and node.sleep(_POLL_PERIOD):
        topic_match = graph.find_topic(full_name)
    if topic_match is None:
        raise CommandError(f"Wrong input topic (or topic field): {full_name}")
    try:
        return topic_match[0], FieldPath(topic_match[2])
    except FieldPathError as error:
        raise CommandError(f"Wrong input topic (or topic field): {full_name}: {error}") from None
