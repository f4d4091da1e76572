"""Shared code of the tools: help and usage errors, nodes, arguments and parameters.

Help and usage errors look like those of separate programs, as users of stock's package topic_tools expect.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import leave_words
from pyros1.cli.records import Argument, Run, Verb
from pyros1.ground import names

if TYPE_CHECKING:
    from pyros1.node import Node
    from pyros1.topic_tools.output import Output

LAZY = "_lazy:=true        subscribe only while the output has subscribers"
"""A line of `Tool`'s parameters."""


class Tool(Verb):
    """A tool without options. Usage errors end it with exit code 1, like stock's.

    Args:
        name: the tool's name.
        about: description in one line, for the list of tools and the tool's help.
        arguments: the arguments, in order.
        run: runs the tool.
        usage: what usage shows after the name; None makes it from the arguments.
        parameters: lines of help about the node's parameters.
        examples: see `Verb`.
        own: whether stock's package topic_tools lacks a tool of this name.
    """

    __slots__ = ("_parameters", "_work")

    def __init__(
        self,
        name: str,
        about: str,
        *arguments: Argument,
        run: Run,
        usage: str | None = None,
        parameters: Sequence[str] = (),
        examples: Sequence[tuple[str, str]] = (),
        own: bool = False,
    ) -> None:
        stock = "" if own else f"rosrun topic_tools {name}"
        super().__init__(
            name, about, *arguments, run=self._run, usage=usage, examples=examples, stock=stock, parse=leave_words
        )
        self._work = run
        self._parameters = parameters

    def _run(self, invocation: Invocation, options: Any, args: list[str]) -> int | None:
        if "-h" in args or "--help" in args:
            print(self._help(invocation.program))
            return 0
        try:
            return self._work(invocation, options, args)
        except UsageError as error:
            if str(error):
                print(f"{self.name}: {error}", file=sys.stderr)
            print(f"\nusage: {self.name} {self.usage}\n")
            return 1

    def _help(self, program: str) -> str:
        text = f"usage: {self.name} {self.usage}\n\n{self.about[0].upper()}{self.about[1:]}.\n"
        if self._parameters:
            text += "\nParameters:\n" + "".join(f"  {line}\n" for line in self._parameters)
        return (text + self.examples_text(program, as_stock=False)).rstrip("\n")


def open_node(invocation: Invocation, base: str) -> Node:
    """Return a node with this name, made unique."""
    from pyros1.node import Node  # noqa: PLC0415 - not needed for help

    if not names.is_legal_base_name(base):
        raise UsageError(f"{base!r} is not a legal node name")
    return Node(base, anonymous=True, argv=invocation.remapping_args, environ=invocation.environ)


def open_node_for(invocation: Invocation, topic: str, tool: str) -> Node:
    """Return a node named after a topic and the tool."""
    from pyros1.topic_tools.output import base_name  # noqa: PLC0415

    return open_node(invocation, f"{base_name(topic)}_{tool}")


def make_relay(node: Node, source: str, target: str, gate: Any = None, latch: bool | None = None) -> tuple[Any, Output]:
    """Return a relay from one topic to another, and its output.

    Args:
        gate: decides which messages pass; None passes all.
        latch: latch the output; None latches it if the input is latched.
    """
    from pyros1.topic_tools.output import Output  # noqa: PLC0415
    from pyros1.topic_tools.relay import Relay  # noqa: PLC0415

    transports = ("udp", "tcp") if flag(node, "unreliable") else ("tcp",)
    output = Output(node, target, latch)
    return Relay(node, source, output, gate, transports), output


def topics(arguments: list[str], tool: str) -> tuple[str, str]:
    """Return input and output. The default name of the output is made from the input's."""
    if not 1 <= len(arguments) <= 2:
        raise UsageError("")
    return arguments[0], arguments[1] if len(arguments) > 1 else f"{arguments[0]}_{tool}"


def flag(node: Node, name: str) -> bool:
    """Return a private boolean parameter, False if it is not set."""
    value = node.params.get(f"~{name}", False)
    if value not in (True, False):
        raise CommandError(f"the parameter ~{name} must be true or false, not {value!r}")
    return bool(value)


def number(node: Node, name: str, default: float) -> float:
    """Return a private parameter that is a number greater than 0."""
    value = node.params.get(f"~{name}", default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value < math.inf:
        raise CommandError(f"the parameter ~{name} must be a number greater than 0, not {value!r}")
    return value
