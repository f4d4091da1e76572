"""``pyros1 log``: rosconsole (L176)."""

from __future__ import annotations

import queue
import re
import sys
from datetime import datetime, timezone
from typing import TYPE_CHECKING, Any, NoReturn

from pyros1.cli.common import CommandError, Invocation, did_you_mean, print_json, program_name, run, use_colour
from pyros1.cli.usage import examples_text
from pyros1.errors import ServiceError, ServiceUnavailableError, WaitTimeoutError
from pyros1.graph import NODE_TIMEOUT
from pyros1.shown import lines, one_line

if TYPE_CHECKING:
    import argparse
    from optparse import OptionParser

    from pyros1.msgs import Message
    from pyros1.node import Node

LEVELS = ["debug", "info", "warn", "error", "fatal"]
_COLOURS = {1: "\x1b[94m", 2: "\x1b[92m", 4: "\x1b[93m", 8: "\x1b[91m", 16: "\x1b[95m"}
_BOLD, _RESET = "\x1b[1m", "\x1b[0m"
_EXAMPLES = {
    "list": {"%prog /talker": "the loggers of a node"},
    "get": {"%prog /talker rosout": "the level of one"},
    "set": {"%prog /talker rosout debug": "hear more of a node, until it ends"},
    "echo": {
        "%prog": "warnings and worse, of all nodes",
        "%prog -l info talker": "more, of the nodes with talker in their name",
        "%prog -v -l error": "with time and place of each error",
    },
}
_LOOK_FOR_END = 0.2
_LOWEST = "warn"
"""The lowest level that is printed, unless the user says another one."""


def usage(program: str) -> str:
    """The command list."""
    program = _program()
    return f"""{program} is a command-line tool for configuring the logger level of ROS nodes.

Commands:
\t{program} get\tdisplay level for a logger
\t{program} list\tlist loggers for a node
\t{program} set\tset level for a logger
\t{program} echo\tprint logger messages

Type {program} <command> -h for more detailed usage, e.g. '{program} list -h'
"""


def main(argv: list[str]) -> int:
    """Run ``log <verb> ...``; returns the exit code."""
    return run("rosconsole", argv, {"get": get, "list": list_loggers, "set": set_level, "echo": echo}, usage)


def _program() -> str:
    """How the user called this command."""
    return program_name("rosconsole")


def _parse(invocation: Invocation, arguments: str, needed: int, wanted: str) -> tuple[OptionParser, list[str], bool]:
    parser = invocation.parser(arguments)
    parser.usage = f"{_program()} {arguments}"
    parser.prog = _program()
    if _program() != "rosconsole":
        verb = invocation.verb
        parser.format_epilog = lambda formatter: examples_text(  # type: ignore[method-assign]
            f"pyros1 log {verb}", _EXAMPLES[verb]
        )
    invocation.add_json(parser)
    options, args = parser.parse_args(invocation.args)
    if len(args) < needed:
        parser.error(f"you must specify {wanted}")
    return parser, args, options.json


def list_loggers(invocation: Invocation) -> None:
    """``log list NODE``."""
    parser, args, json = _parse(invocation, "list <node>", 1, "a node to list loggers")
    if len(args) > 1:
        parser.error("you may only specify one node to list")
    with invocation.open_node() as node:
        loggers = _loggers(invocation, node, invocation.resolve(args[0]))
        if json:
            print_json([{"logger": name, "level": level} for name, level in loggers.items()])
        elif loggers:
            print(*map(one_line, loggers), sep="\n")


def get(invocation: Invocation) -> None:
    """``log get NODE LOGGER``."""
    _, args, json = _parse(invocation, "get <node> <logger>", 2, "a node and a logger")
    name = invocation.resolve(args[0])
    with invocation.open_node() as node:
        loggers = _loggers(invocation, node, name)
        if args[1] not in loggers:
            _no_logger(name, args[1], loggers)
        if json:
            print_json(loggers[args[1]])
        else:
            print(one_line(loggers[args[1]]))


def set_level(invocation: Invocation) -> None:
    """``log set NODE LOGGER LEVEL``."""
    arguments = f"set <node> <logger> <level>\n\n <level> must be one of [{', '.join(LEVELS)}]"
    parser, args, _ = _parse(invocation, arguments, 3, "a node, a logger and a level")
    name, logger, level = invocation.resolve(args[0]), args[1], args[2].lower()
    if level not in LEVELS:
        parser.error(f"invalid level{did_you_mean(level, LEVELS)}")
    with invocation.open_node() as node:
        loggers = _loggers(invocation, node, name)
        if logger not in loggers:
            _no_logger(name, logger, loggers)
        _call(invocation, node, name, "set_logger_level", {"logger": logger, "level": level})


def _no_logger(node: str, logger: str, loggers: dict[str, str]) -> NoReturn:
    raise CommandError(
        f"{_program()}: error: node {node} does not contain logger {one_line(logger)}{did_you_mean(logger, loggers)}",
        2,
        plain=True,
    )


def _loggers(invocation: Invocation, node: Node, name: str) -> dict[str, str]:
    response = _call(invocation, node, name, "get_loggers", {})
    return {logger.name: logger.level for logger in response.loggers}


def _call(invocation: Invocation, node: Node, name: str, what: str, request: dict[str, str]) -> Any:
    """Call one of the two services that each node offers for its log."""
    service = f"{name}/{what}"
    service_type = "roscpp/GetLoggers" if what == "get_loggers" else "roscpp/SetLoggerLevel"
    try:
        client = node.service(service, service_type)
        return client.call(client.type._request_class(**request), NODE_TIMEOUT)
    except WaitTimeoutError:
        text = f"node '{name}' does not answer within {NODE_TIMEOUT:g} s"
    except ServiceUnavailableError:
        hint = did_you_mean(name, invocation.graph.state().nodes())
        text = f"node '{name}' doesn't exist or doesn't support query: Service [{service}] is not available.{hint}"
    except ServiceError as error:
        text = f"node '{name}' logger request failed: {error}"
    raise CommandError(f"{_program()}: error: {text}", 1, plain=True)


# Echo -----------------------------------------------------------------------------------------------------------------


def echo(invocation: Invocation) -> None:
    """``log echo [REGEX]``: messages of all nodes as they come."""
    options = _echo_options(invocation)
    try:
        pattern = re.compile(options.filter)
    except re.error as error:
        raise CommandError(f"{options.filter!r} is not a regular expression: {error}", 2) from None
    lowest = 1 << LEVELS.index(options.level or _LOWEST)
    told = False
    topic = options.topic and invocation.resolve(options.topic)
    if topic is None:
        # The aggregator has everybody's messages in one connection; without one each node is asked itself.
        topic = "/rosout_agg" if invocation.graph.state().publishers.get("/rosout_agg") else "/rosout"
    colour = not options.nocolor and use_colour(sys.stdout)
    arrived: queue.SimpleQueue[Message] = queue.SimpleQueue()
    with invocation.open_node() as node, node.subscribe(topic, "rosgraph_msgs/Log", arrived.put):
        while node.ok():
            try:
                message: Any = arrived.get(timeout=_LOOK_FOR_END)
            except queue.Empty:
                continue
            if not pattern.search(message.name):
                continue
            if message.level < lowest:
                if options.level is None and not told:
                    told = True
                    wanted = _level(message.level)
                    print(
                        f"{_program()} echo: what is below {_LOWEST} is hidden: see it with -l {wanted}",
                        file=sys.stderr,
                    )
                continue
            if options.json:
                print_json(as_json(message))
            else:
                print(line(message, colour=colour, verbose=options.verbose))
            sys.stdout.flush()
            if options.once:
                return


def _echo_options(invocation: Invocation) -> argparse.Namespace:
    import argparse  # noqa: PLC0415 - the other verbs use optparse, as the stock tool does

    stock = _program() == "rosconsole"
    parser = argparse.ArgumentParser(
        prog=f"{_program()} echo",
        description="Print logger messages",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=None if stock else examples_text("pyros1 log echo", _EXAMPLES["echo"]).lstrip(),
    )
    parser.add_argument(
        "filter",
        metavar="FILTER",
        nargs="?",
        default=".*",
        help="regular expression to filter the node's name (default: %(default)s)",
    )
    parser.add_argument(
        "-l",
        "--level",
        choices=LEVELS,
        type=str if stock else str.lower,
        metavar="LEVEL",
        help=f"lowest level to print, one of {', '.join(LEVELS)} (default: {_LOWEST})",
    )
    parser.add_argument("-1", "--once", action="store_true", help="print one message and exit")
    parser.add_argument("--topic", help="topic to read (default: /rosout_agg if somebody publishes it, else /rosout)")
    parser.add_argument("--nocolor", action="store_true", help="output without color, also on a terminal")
    parser.add_argument("-v", "--verbose", action="store_true", help="print when and where it was logged, too")
    parser.add_argument("--json", action="store_true", help=argparse.SUPPRESS if stock else "print lines of JSON")
    return parser.parse_args(invocation.args)


def line(message: Any, *, colour: bool = False, verbose: bool = False) -> str:
    """Return a message as it is printed.

    Args:
        message: a rosgraph_msgs/Log.
        colour: with escape sequences.
        verbose: a second line says when and where it was logged.
    """
    level, name = _level(message.level).upper(), one_line(message.name)
    shown = f"{level:5}"
    if colour:
        shown, name = f"{_COLOURS.get(message.level, '')}{shown}{_RESET}", f"{_BOLD}{name}{_RESET}"
    text = f"[ {shown} ] [{name}]: " + lines(message.msg).replace("\n", "\n  ")  # so that none passes for another's
    if not verbose:
        return text
    stamp = message.header.stamp
    seconds = stamp.secs + stamp.nsecs / 1e9
    moment = datetime.fromtimestamp(seconds, timezone.utc)
    place = f"[{one_line(message.function)}]: {one_line(message.file)}:{message.line}"
    return f"{text}\n          [{moment} ({seconds:.6f})] {place}"


def as_json(message: Any) -> dict[str, Any]:
    """Return a message's level, node, text, time in seconds, and place, for programs."""
    return {
        "level": _level(message.level),
        "node": message.name,
        "text": message.msg,
        "stamp": message.header.stamp.secs + message.header.stamp.nsecs / 1e9,
        "function": message.function,
        "file": message.file,
        "line": message.line,
    }


def _level(number: int) -> str:
    """The name of a level; a level that does not exist is shown as its number."""
    return next((name for bit, name in enumerate(LEVELS) if 1 << bit == number), str(number))
