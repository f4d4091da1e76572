"""``log get``."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.log._loggers import get_loggers, no_logger
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON, Argument, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.ground.shown import one_line


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the level of a logger."""
    if len(args) < 2:
        raise UsageError("you must specify a node and a logger")
    name, logger = invocation.resolve(args[0]), args[1]
    with invocation.open_node() as node:
        loggers = get_loggers(invocation, node, name)
        if logger not in loggers:
            raise no_logger(invocation, name, logger, loggers)
        if options.json:
            print_json(loggers[logger])
        else:
            print(one_line(loggers[logger]))


VERB = Verb(
    "get",
    "display level for a logger",
    JSON,
    Argument("node", "node"),
    Argument("logger"),
    usage="<node> <logger>",
    examples=[("/talker rosout", "the level of one logger")],
    run=run,
)
