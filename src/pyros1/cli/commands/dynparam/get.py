"""``dynparam get``."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.dynparam._arguments import TIMEOUT, check
from pyros1.cli.commands.dynparam._server import Server
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import parse_with_negative_numbers
from pyros1.cli.records import JSON, Argument, Verb
from pyros1.cli.shared.printing import print_json


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print a node's configuration as a Python dictionary, which is also YAML."""
    check(args, "a node name")
    values = None
    with invocation.open_node() as node:  # Ctrl-C ends the wait, and this block silently
        values = Server(invocation, node, args[0], options.timeout).configuration()
    if values is None:
        return
    if options.json:
        print_json(values)
    else:
        print(values)


VERB = Verb(
    "get",
    "print a node's configuration",
    TIMEOUT,
    JSON,
    Argument("node", "configurable"),
    examples=[("/camera", "all parameters of a node"), ("--json /camera", "for programs")],
    parse=parse_with_negative_numbers,
    run=run,
)
