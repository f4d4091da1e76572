"""``log list``."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.log._loggers import get_loggers
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON, Argument, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.ground.shown import one_line


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the loggers of a node."""
    if not args:
        raise UsageError("you must specify a node to list loggers")
    if len(args) > 1:
        raise UsageError("you may only specify one node to list")
    with invocation.open_node() as node:
        loggers = get_loggers(invocation, node, invocation.resolve(args[0]))
        if options.json:
            print_json([{"logger": name, "level": level} for name, level in loggers.items()])
        elif loggers:
            print(*map(one_line, loggers), sep="\n")


VERB = Verb(
    "list",
    "list loggers for a node",
    JSON,
    Argument("node", "node"),
    usage="<node>",
    examples=[("/talker", "the loggers of a node")],
    run=run,
)
