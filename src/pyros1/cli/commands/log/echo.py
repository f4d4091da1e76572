"""``log echo``: prints log messages as they arrive."""

from __future__ import annotations

import re
import sys
from datetime import datetime, timezone
from typing import Any

from pyros1.cli.commands.log._loggers import LEVELS
from pyros1.cli.commands.log._messages import BOLD, COLOURS, RESET, as_json, level_name, receive_messages
from pyros1.cli.failures import CommandError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.printing import print_json, should_use_colour
from pyros1.ground.terminal_text import lines, one_line

_DEFAULT_LEVEL = "warn"
"""The default lowest level to print."""


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print log messages of the nodes whose names match, as they arrive."""
    try:
        pattern = re.compile(args[0])
    except re.error as error:
        raise CommandError(f"{args[0]!r} is not a regular expression: {error}", 2) from None
    lowest_level = 1 << LEVELS.index(options.level or _DEFAULT_LEVEL)
    has_warned = False
    coloured = not options.nocolor and should_use_colour(sys.stdout)
    for message in receive_messages(invocation, options.topic and invocation.resolve(options.topic)):
        if not pattern.search(message.name):
            continue
        if message.level < lowest_level:
            if options.level is None and not has_warned:
                has_warned = True
                level = level_name(message.level)
                print(
                    f"{invocation.program} echo: messages below {_DEFAULT_LEVEL} are hidden: "
                    f"use -l {level} to see them",
                    file=sys.stderr,
                )
            continue
        if options.json:
            print_json(as_json(message))
        else:
            print(format_message(message, coloured=coloured, verbose=options.verbose))
        sys.stdout.flush()
        if options.once:
            return


def _parse(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    from pyros1.cli.shared.argparsing import add_options_and_arguments, make_parser  # noqa: PLC0415 - not needed for completion

    parser = make_parser(invocation, verb)
    add_options_and_arguments(parser, invocation, *verb.options)
    filter_help = "regular expression to filter the node's name (default: %(default)s)"
    parser.add_argument("filter", metavar="FILTER", nargs="?", default=".*", help=filter_help)
    options = parser.parse_args(invocation.args)
    if options.level is not None and not invocation.as_stock:
        options.level = options.level.lower()
    if options.level not in (None, *LEVELS):
        choices = ", ".join(map(repr, LEVELS))
        parser.error(f"argument -l/--level: invalid choice: {options.level!r} (choose from {choices})")
    return options, [options.filter]


VERB = Verb(
    "echo",
    "print logger messages",
    Option(
        "-l",
        "--level",
        metavar="LEVEL",
        help=f"lowest level to print, one of {', '.join(LEVELS)} (default: {_DEFAULT_LEVEL})",
    ),
    Flag("-1", "--once", help="print one message and exit"),
    Option("--topic", help="topic to read (default: /rosout_agg if it is published, else /rosout)"),
    Flag("--nocolor", help="no color, even on a terminal"),
    Flag("-v", "--verbose", help="also print the time and source location of each message"),
    Flag("--json", help="print lines of JSON", pyros1_only=True),
    Argument("FILTER", "node", optional=True),
    description="Print logger messages",
    examples=[
        ("", "print warnings and errors of all nodes"),
        ("-l info talker", "print more messages, of nodes with talker in their names"),
        ("-v -l error", "print errors with their time and source location"),
    ],
    parse=_parse,
    run=run,
)


def format_message(message: Any, *, coloured: bool = False, verbose: bool = False) -> str:
    """Return a message as one or more lines of text.

    Args:
        message: a rosgraph_msgs/Log message.
        coloured: whether to use escape sequences for colours.
        verbose: whether to add a line with the time and source location.
    """
    level, name = level_name(message.level).upper(), one_line(message.name)
    label = f"{level:5}"
    if coloured:
        label, name = f"{COLOURS.get(message.level, '')}{label}{RESET}", f"{BOLD}{name}{RESET}"
    # Further lines are indented, so that no line looks like another message.
    text = f"[ {label} ] [{name}]: " + lines(message.msg).replace("\n", "\n  ")
    if not verbose:
        return text
    stamp = message.header.stamp
    seconds = stamp.secs + stamp.nsecs / 1e9
    utc_time = datetime.fromtimestamp(seconds, timezone.utc)
    location = f"[{one_line(message.function)}]: {one_line(message.file)}:{message.line}"
    return f"{text}\n          [{utc_time} ({seconds:.6f})] {location}"
