"""``pyros1 console``: prints the log messages of all nodes, like rqt_console."""

from __future__ import annotations

import os
import re
import sys
import time
from typing import Any

from pyros1.cli.commands.log._loggers import LEVELS
from pyros1.cli.commands.log._messages import BOLD, COLOURS, DIM, RESET, as_json, level_name, receive_messages
from pyros1.cli.failures import UsageError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON_FLAG, Command, Flag, Option, Verb
from pyros1.cli.shared.printing import print_json, should_use_colour
from pyros1.ground.terminal_text import lines, one_line

_DEFAULT_LEVEL = "info"
_SIMULATED_TIME_LIMIT = 100_000_000
"""A time in 1973, as seconds since 1970. Messages with earlier times are assumed to have simulated time."""


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print log messages of all nodes as they arrive, until enough have been printed or a signal arrives."""
    if args:
        raise UsageError(f"console takes no arguments; to select a node: --node {args[0]}")
    if options.count is not None and options.count < 1:
        raise UsageError("--count needs a number of at least 1")
    message_filter = MessageFilter(options)
    coloured = not options.nocolor and should_use_colour(sys.stdout)
    remaining_count = options.count
    if sys.stderr.isatty():
        print(_earlier_logs_hint(), file=sys.stderr)
    for message in receive_messages(invocation):
        if not message_filter.matches(message):
            continue
        if options.json:
            print_json(as_json(message))
        else:
            print(format_row(message, coloured=coloured))
        sys.stdout.flush()
        remaining_count = remaining_count and remaining_count - 1
        if remaining_count == 0:
            return


class MessageFilter:
    """Selects the log messages to print.

    Args:
        options: the parsed options of the command.

    Raises:
        UsageError: an option is invalid.
    """

    def __init__(self, options: Any) -> None:
        level = options.level.lower()
        if level not in LEVELS:
            raise UsageError(f"there is no level {options.level!r}{did_you_mean(level, LEVELS)}: {', '.join(LEVELS)}")
        self._lowest_level = 1 << LEVELS.index(level)
        self._node_patterns = [_compile_pattern("--node", pattern) for pattern in options.nodes or ()]
        self._included_patterns = [_compile_pattern("--grep", pattern) for pattern in options.texts or ()]
        self._excluded_patterns = [_compile_pattern("--exclude", pattern) for pattern in options.excluded or ()]

    def matches(self, message: Any) -> bool:
        """Return whether to print a rosgraph_msgs/Log message."""
        return bool(
            message.level >= self._lowest_level
            and (not self._node_patterns or any(pattern.search(message.name) for pattern in self._node_patterns))
            and all(pattern.search(message.msg) for pattern in self._included_patterns)
            and not any(
                pattern.search(message.msg) or pattern.search(message.name) for pattern in self._excluded_patterns
            )
        )


def _compile_pattern(option_name: str, pattern: str) -> re.Pattern[str]:
    try:
        return re.compile(pattern, re.IGNORECASE)
    except re.error as error:
        raise UsageError(f"{option_name} needs a regular expression, not {pattern!r}: {error}") from None


def format_row(message: Any, *, coloured: bool = False) -> str:
    """Return a rosgraph_msgs/Log message as a line: time, severity, node, text and source location.

    Args:
        message: the message. All lines of its text except the first are indented.
        coloured: whether to use escape sequences for colours.
    """
    severity = f"{level_name(message.level).upper():5}"
    node, text = one_line(message.name), lines(message.msg).rstrip("\n").replace("\n", "\n    ")
    location = _source_location(message)
    time_text = _format_time(message.header.stamp.secs, message.header.stamp.nsecs)
    if not coloured:
        return f"{time_text} {severity} {node}: {text}{location and f'  [{location}]'}"
    location = location and f"  {DIM}[{location}]{RESET}"
    level_colour = COLOURS.get(message.level, "")
    return f"{DIM}{time_text}{RESET} {level_colour}{severity}{RESET} {BOLD}{node}{RESET}: {text}{location}"


def _source_location(message: Any) -> str:
    if not message.file:
        return one_line(message.function)
    file_and_line = f"{os.path.basename(one_line(message.file))}:{message.line}"
    return f"{file_and_line} {one_line(message.function)}".rstrip()


def _format_time(seconds: int, nanoseconds: int) -> str:
    if seconds < _SIMULATED_TIME_LIMIT:
        return f"{seconds + nanoseconds / 1e9:12.3f}"
    return f"{time.strftime('%H:%M:%S', time.localtime(seconds))}.{nanoseconds // 1_000_000:03}"


def _earlier_logs_hint() -> str:
    """Return a hint about where to find earlier messages, since /rosout does not repeat them."""
    from pyros1.launch.running.logs import log_folder  # noqa: PLC0415 - only needed on terminals

    file = log_folder(os.environ) / "latest" / "rosout.log"
    earlier_hint = (
        f"; earlier ones are in {file}" if file.exists() else "; pyros1 web keeps earlier ones while it is running"
    )
    return f"showing messages from now on{earlier_hint}"


COMMAND = Command(
    "console",
    "print log messages of all nodes as they arrive",
    Verb(
        "",
        "",
        Option(
            "-l",
            "--level",
            metavar="LEVEL",
            default=_DEFAULT_LEVEL,
            help=f"lowest severity to show, one of {', '.join(LEVELS)} ({_DEFAULT_LEVEL})",
        ),
        Option(
            "-n",
            "--node",
            dest="nodes",
            action="append",
            metavar="PATTERN",
            help="show only nodes whose names match; may be repeated",
        ),
        Option(
            "-g",
            "--grep",
            dest="texts",
            action="append",
            metavar="PATTERN",
            help="show only messages whose text matches; may be repeated: all must match",
        ),
        Option(
            "-x",
            "--exclude",
            dest="excluded",
            action="append",
            metavar="PATTERN",
            help="hide messages whose text or node matches; may be repeated",
        ),
        Option("-c", "--count", type="int", metavar="COUNT", help="exit after this many messages"),
        Flag("--nocolor", help="no color, even on a terminal"),
        JSON_FLAG,
        usage="[options]",
        description="Prints the time, severity, node, text and code location of each message. Patterns are regular\n"
        "expressions that ignore case. pyros1 web console shows the same in a browser.",
        examples=[
            ("", "print all except debug messages"),
            ("-l warn", "print warnings and errors"),
            ("-n driver -g timeout", "print messages about timeouts from nodes with driver in their names"),
        ],
        run=run,
    ),
    group="inspect",
)
