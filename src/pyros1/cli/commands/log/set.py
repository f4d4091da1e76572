"""``log set``."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.log._loggers import LEVELS, call, get_loggers, no_logger
from pyros1.cli.failures import UsageError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON, Argument, Verb


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Set the level of a logger."""
    if len(args) < 3:
        raise UsageError("you must specify a node, a logger and a level")
    name, logger, level = invocation.resolve(args[0]), args[1], args[2].lower()
    if level not in LEVELS:
        raise UsageError(f"invalid level{did_you_mean(level, LEVELS)}")
    with invocation.open_node() as node:
        loggers = get_loggers(invocation, node, name)
        if logger not in loggers:
            raise no_logger(invocation, name, logger, loggers)
        call(invocation, node, name, "set_logger_level", {"logger": logger, "level": level})


VERB = Verb(
    "set",
    "set level for a logger",
    JSON,
    Argument("node", "node"),
    Argument("logger"),
    Argument("level"),
    usage=f"<node> <logger> <level>\n\n <level> must be one of [{', '.join(LEVELS)}]",
    examples=[("/talker rosout debug", "more messages from a node, until it exits")],
    run=run,
)
