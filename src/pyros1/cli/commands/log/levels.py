"""``log list``, ``get`` and ``set``: print and set the levels of a node's loggers."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.log._loggers import LEVELS, call_logger_service, get_loggers, unknown_logger_error
from pyros1.cli.failures import UsageError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON_FLAG, Argument, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.ground.terminal_text import one_line


def _print_loggers(invocation: Invocation, options: Any, args: list[str]) -> None:
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


def _print_level(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the level of a logger."""
    if len(args) < 2:
        raise UsageError("you must specify a node and a logger")
    node_name, logger = invocation.resolve(args[0]), args[1]
    with invocation.open_node() as node:
        loggers = get_loggers(invocation, node, node_name)
        if logger not in loggers:
            raise unknown_logger_error(invocation, node_name, logger, loggers)
        if options.json:
            print_json(loggers[logger])
        else:
            print(one_line(loggers[logger]))


def _set_level(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Set the level of a logger."""
    if len(args) < 3:
        raise UsageError("you must specify a node, a logger and a level")
    node_name, logger, level = invocation.resolve(args[0]), args[1], args[2].lower()
    if level not in LEVELS:
        raise UsageError(f"invalid level{did_you_mean(level, LEVELS)}")
    with invocation.open_node() as node:
        loggers = get_loggers(invocation, node, node_name)
        if logger not in loggers:
            raise unknown_logger_error(invocation, node_name, logger, loggers)
        call_logger_service(invocation, node, node_name, "set_logger_level", {"logger": logger, "level": level})


VERBS = [
    Verb(
        "list",
        "list loggers for a node",
        JSON_FLAG,
        Argument("node", "node"),
        usage="<node>",
        examples=[("/talker", "print the loggers of a node")],
        run=_print_loggers,
    ),
    Verb(
        "get",
        "display level for a logger",
        JSON_FLAG,
        Argument("node", "node"),
        Argument("logger"),
        usage="<node> <logger>",
        examples=[("/talker rosout", "print the level of one logger")],
        run=_print_level,
    ),
    Verb(
        "set",
        "set level for a logger",
        JSON_FLAG,
        Argument("node", "node"),
        Argument("logger"),
        Argument("level"),
        usage=f"<node> <logger> <level>\n\n <level> must be one of [{', '.join(LEVELS)}]",
        examples=[("/talker rosout debug", "log more messages of a node until it exits")],
        run=_set_level,
    ),
]
