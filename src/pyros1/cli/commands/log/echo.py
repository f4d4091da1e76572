"""``log echo``."""

from __future__ import annotations

import queue
import re
import sys
from datetime import datetime, timezone
from typing import TYPE_CHECKING, Any

from pyros1.cli.commands.log._loggers import LEVELS
from pyros1.cli.failures import CommandError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.printing import print_json, use_colour
from pyros1.ground.shown import lines, one_line

if TYPE_CHECKING:
    from pyros1.msgs import Message

_COLOURS = {1: "\x1b[94m", 2: "\x1b[92m", 4: "\x1b[93m", 8: "\x1b[91m", 16: "\x1b[95m"}
_BOLD, _RESET = "\x1b[1m", "\x1b[0m"
_LOOK_FOR_END = 0.2
_LOWEST = "warn"
"""The default of the lowest level that is printed."""


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print messages of all nodes as they arrive."""
    try:
        pattern = re.compile(args[0])
    except re.error as error:
        raise CommandError(f"{args[0]!r} is not a regular expression: {error}", 2) from None
    lowest = 1 << LEVELS.index(options.level or _LOWEST)
    told = False
    topic = options.topic and invocation.resolve(options.topic)
    if topic is None:
        # An aggregator provides all messages over one connection. Without one, each node needs a connection.
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
                        f"{invocation.program} echo: messages below {_LOWEST} are hidden: use -l {wanted} to see them",
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


def _parse(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    from pyros1.cli.shared.argparsing import add_parts, make_parser  # noqa: PLC0415 - completion does without

    parser = make_parser(invocation, verb)
    add_parts(parser, invocation, *verb.options)
    about = "regular expression to filter the node's name (default: %(default)s)"
    parser.add_argument("filter", metavar="FILTER", nargs="?", default=".*", help=about)
    options = parser.parse_args(invocation.args)
    if options.level is not None and not invocation.as_stock:
        options.level = options.level.lower()
    if options.level not in (None, *LEVELS):
        known = ", ".join(map(repr, LEVELS))
        parser.error(f"argument -l/--level: invalid choice: {options.level!r} (choose from {known})")
    return options, [options.filter]


VERB = Verb(
    "echo",
    "print logger messages",
    Option(
        "-l",
        "--level",
        metavar="LEVEL",
        help=f"lowest level to print, one of {', '.join(LEVELS)} (default: {_LOWEST})",
    ),
    Flag("-1", "--once", help="print one message and exit"),
    Option("--topic", help="topic to read (default: /rosout_agg if it is published, else /rosout)"),
    Flag("--nocolor", help="no color, even on a terminal"),
    Flag("-v", "--verbose", help="also print the time and place of each message"),
    Flag("--json", help="print lines of JSON", own=True),
    Argument("FILTER", "node", optional=True),
    description="Print logger messages",
    examples=[
        ("", "warnings and errors of all nodes"),
        ("-l info talker", "more messages, from nodes with talker in their names"),
        ("-v -l error", "errors with their time and place"),
    ],
    parse=_parse,
    run=run,
)


def line(message: Any, *, colour: bool = False, verbose: bool = False) -> str:
    """Return a message as text.

    Args:
        message: a rosgraph_msgs/Log.
        colour: use escape sequences.
        verbose: add a second line with the time and place.
    """
    level, name = _level(message.level).upper(), one_line(message.name)
    shown = f"{level:5}"
    if colour:
        shown, name = f"{_COLOURS.get(message.level, '')}{shown}{_RESET}", f"{_BOLD}{name}{_RESET}"
    text = f"[ {shown} ] [{name}]: " + lines(message.msg).replace(
        "\n", "\n  "
    )  # so that no line looks like another message
    if not verbose:
        return text
    stamp = message.header.stamp
    seconds = stamp.secs + stamp.nsecs / 1e9
    moment = datetime.fromtimestamp(seconds, timezone.utc)
    place = f"[{one_line(message.function)}]: {one_line(message.file)}:{message.line}"
    return f"{text}\n          [{moment} ({seconds:.6f})] {place}"


def as_json(message: Any) -> dict[str, Any]:
    """Return a message's level, node, text, time in seconds and place, for JSON."""
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
    """Return the name of a level, or its number if the level does not exist."""
    return next((name for bit, name in enumerate(LEVELS) if 1 << bit == number), str(number))
