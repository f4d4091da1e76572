"""Shared code of the tools: help, usage errors, nodes, arguments and parameters.

Help and usage errors look as if each tool were a separate program, as in the stock package.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import leave_unparsed
from pyros1.cli.records import Argument, RunFunction, Verb
from pyros1.ground import names

if TYPE_CHECKING:
    from pyros1.node import Node
    from pyros1.topic_tools.output import Output

LAZY_HELP = "_lazy:=true        subscribe only while the output has subscribers"
"""The line about the parameter ``~lazy`` in a tool's help."""


class Tool(Verb):
    """A tool without options. As in stock ROS, the exit code after usage errors is 1.

    Args:
        name: the tool's name.
        about: a one-line description for the list of tools and the tool's help.
        arguments: the arguments in order.
        run: the function that runs the tool.
        usage: the usage after the name; None to generate it from the arguments.
        parameters: the lines about the node's parameters in the tool's help.
        examples: the examples, see `Verb`.
        pyros1_only: whether the stock package topic_tools lacks a tool of this name.
    """

    __slots__ = ("_parameters", "_run_tool")

    def __init__(
        self,
        name: str,
        about: str,
        *arguments: Argument,
        run: RunFunction,
        usage: str | None = None,
        parameters: Sequence[str] = (),
        examples: Sequence[tuple[str, str]] = (),
        pyros1_only: bool = False,
    ) -> None:
        stock = "" if pyros1_only else f"rosrun topic_tools {name}"
        super().__init__(
            name, about, *arguments, run=self._run, usage=usage, examples=examples, stock=stock, parse=leave_unparsed
        )
        self._run_tool = run
        self._parameters = parameters

    def _run(self, invocation: Invocation, options: Any, args: list[str]) -> int | None:
        if "-h" in args or "--help" in args:
            print(self._help(invocation.program))
            return 0
        try:
            return self._run_tool(invocation, options, args)
        except UsageError as error:
            if str(error):
                print(f"{self.name}: {error}", file=sys.stderr)
            print(f"\nusage: {self.name} {self.usage}\n")
            return 1

    def _help(self, program: str) -> str:
        help_text = f"usage: {self.name} {self.usage}\n\n{self.about[0].upper()}{self.about[1:]}.\n"
        if self._parameters:
            help_text += "\nParameters:\n" + "".join(f"  {line}\n" for line in self._parameters)
        return (help_text + self.examples_text(program, as_stock=False)).rstrip("\n")


def open_node(invocation: Invocation, base_name: str) -> Node:
    """Create and return a node whose name is unique and starts with the given name.

    Raises:
        UsageError: the name is not legal.
    """
    from pyros1.node import Node  # noqa: PLC0415 - not needed for help

    if not names.is_legal_base_name(base_name):
        raise UsageError(f"{base_name!r} is not a legal node name")
    return Node(base_name, anonymous=True, argv=invocation.remapping_args, environ=invocation.environ)


def open_node_for(invocation: Invocation, topic: str, tool: str) -> Node:
    """Create and return a node named after a topic and the tool."""
    from pyros1.topic_tools.output import base_name  # noqa: PLC0415

    return open_node(invocation, f"{base_name(topic)}_{tool}")


def make_relay(node: Node, source: str, target: str, gate: Any = None, latch: bool | None = None) -> tuple[Any, Output]:
    """Create a relay from one topic to another. Return the relay and its output.

    Args:
        node: the tool's node.
        source: the input topic.
        target: the output topic.
        gate: called with each message; returns whether to forward the message. If None, all messages are forwarded.
        latch: whether to latch the output; None to latch it if the input is latched.
    """
    from pyros1.topic_tools.output import Output  # noqa: PLC0415
    from pyros1.topic_tools.relay import Relay  # noqa: PLC0415

    transports = ("udp", "tcp") if bool_param(node, "unreliable") else ("tcp",)
    output = Output(node, target, latch)
    return Relay(node, source, output, gate, transports), output


def input_and_output(arguments: list[str], tool: str) -> tuple[str, str]:
    """Return the input and output topics. By default, the output is named after the input and the tool.

    Raises:
        UsageError: there are too few or too many arguments.
    """
    if not 1 <= len(arguments) <= 2:
        raise UsageError("")
    return arguments[0], arguments[1] if len(arguments) > 1 else f"{arguments[0]}_{tool}"


def bool_param(node: Node, name: str) -> bool:
    """Return the value of a private boolean parameter; False if it is not set.

    Raises:
        CommandError: the value is not boolean.
    """
    value = node.params.get(f"~{name}", False)
    if value not in (True, False):
        raise CommandError(f"the parameter ~{name} must be true or false, not {value!r}")
    return bool(value)


def positive_param(node: Node, name: str, default: float) -> float:
    """Return the value of a private parameter that must be a number greater than 0.

    Raises:
        CommandError: the value is not such a number.
    """
    value = node.params.get(f"~{name}", default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value < math.inf:
        raise CommandError(f"the parameter ~{name} must be a number greater than 0, not {value!r}")
    return value
