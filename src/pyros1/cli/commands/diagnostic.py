"""``pyros1 diagnostic``: shows diagnostics, like rosdiagnostic (L202, https://wiki.ros.org/rosdiagnostic)."""

from __future__ import annotations

import queue
import re
import sys
from collections.abc import Iterator, Sequence
from datetime import datetime, timezone
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.cli.failures import CommandError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Command, Flag, Option, Verb
from pyros1.cli.shared.printing import print_json, should_use_colour
from pyros1.ground.terminal_text import one_line

if TYPE_CHECKING:
    from pyros1.msgs import Message

LEVELS = ["ok", "warn", "error", "stale"]
"""Names of the levels, indexed by their number."""
_NUMBERED_LEVELS = ", ".join(f"{number} {name}" for number, name in enumerate(LEVELS))
_LEVEL_LABELS = [" OK  ", "WARN ", "ERROR", "STALE"]
_COLOURS = ["\x1b[92m", "\x1b[93m", "\x1b[91m", "\x1b[94m"]
_RESET = "\x1b[0m"
_WIDTH = 69
_POLL_PERIOD = 0.2
_AGGREGATED_TOPIC, _RAW_TOPIC = "/diagnostics_agg", "/diagnostics"
_GATHER_TIMEOUT = 2.0
"""Seconds to wait for messages from all nodes. Most nodes publish once per second."""
_MESSAGE_TYPE = "diagnostic_msgs/DiagnosticArray"


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the diagnostics of at least the level ``--level``: once, or as they arrive with ``--follow``."""
    try:
        pattern = re.compile(options.filter)
    except re.error as error:
        raise CommandError(f"{options.filter!r} is not a regular expression: {error}", 2) from None
    topic, source_count = _choose_topic(invocation, options.topic)
    coloured = not options.nocolor and should_use_colour(sys.stdout)
    messages: queue.SimpleQueue[Message] = queue.SimpleQueue()
    with invocation.open_node() as node, node.subscribe(topic, _MESSAGE_TYPE, messages.put):
        _warn_if_unpublished(invocation, node.resolve(topic))
        while node.ok():
            try:
                message: Any = messages.get(timeout=_POLL_PERIOD)
            except queue.Empty:
                continue
            if source_count > 1 and not options.follow:
                _gather_statuses(message, messages, source_count)
            statuses_to_print = select_statuses(message.status, options.level, pattern)
            if options.json:
                print_json(as_json(message, statuses_to_print))
            elif options.follow:
                _print_lines(status_lines(message, statuses_to_print, detail=options.detail, coloured=coloured))
            else:
                _print_lines([f"{'=' * _WIDTH}", f"Diagnostics generated on: {_local_time(message)}", "-" * _WIDTH])
                _print_lines(status_lines(message, statuses_to_print, detail=options.detail, coloured=coloured))
                _print_lines(["=" * _WIDTH])
            sys.stdout.flush()
            if not options.follow:
                return


def _parse(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    from pyros1.cli.shared.argparsing import add_options_and_arguments, make_parser  # noqa: PLC0415 - not needed for completion

    parser = make_parser(invocation, verb)
    add_options_and_arguments(parser, invocation, *verb.options)
    options = parser.parse_args(invocation.args)
    level = str(options.level).lower()
    if level in LEVELS:
        options.level = LEVELS.index(level)
    elif level in {str(number) for number in range(len(LEVELS))}:
        options.level = int(level)
    else:
        hint = did_you_mean(level, LEVELS)
        parser.error(f"argument -l/--level: unknown level {options.level!r}{hint}; levels: {_NUMBERED_LEVELS}")
    return options, []


COMMAND = Command(
    "diagnostic",
    "show the diagnostics of the robot's components",
    Verb(
        "",
        "",
        Flag("-f", "--follow", help="keep printing new messages"),
        Option(
            "-l",
            "--level",
            default="1",
            metavar="LEVEL",
            help=f"lowest level to print: {_NUMBERED_LEVELS} (default: 1)",
        ),
        Option(
            "--topic",
            default="",
            help=f"topic to read (default: {_AGGREGATED_TOPIC}; without an aggregator {_RAW_TOPIC})",
        ),
        Option(
            "--filter",
            default=".*",
            metavar="REGEX",
            help="print only statuses whose names match this regular expression",
        ),
        Flag("--nocolor", help="no color, even on a terminal"),
        Flag("-d", "--detail", help="also print time, hardware and all values"),
        Flag("--json", help="print a line of JSON", pyros1_only=True),
        description="Print the diagnostics of the robot's components.",
        examples=[
            ("", "print warnings and errors"),
            ("-l ok -d", "print everything, with all values"),
            ("-f --filter battery", "follow the state of the battery"),
            ("--topic /diagnostics", "print diagnostics as the nodes publish them"),
        ],
        parse=_parse,
        run=run,
    ),
    group="inspect",
    stock="rosdiagnostic",
)


def _choose_topic(invocation: Invocation, requested: str) -> tuple[str, int]:
    """Return the topic to read, and the number of nodes whose messages together describe the robot's state.

    If no topic is requested and there is no aggregator, as on many robots, it is the topic on which nodes publish.
    """
    topic = invocation.resolve(requested or _AGGREGATED_TOPIC)
    raw_topic = invocation.resolve(_RAW_TOPIC)
    if requested or invocation.as_stock:
        return topic, 1
    publishers_by_topic = invocation.graph.state().publishers
    if publishers_by_topic.get(topic) or not publishers_by_topic.get(raw_topic):
        return topic, 1
    print(f"nothing publishes {topic}; showing what nodes publish on {raw_topic} instead", file=sys.stderr, flush=True)
    return raw_topic, len(publishers_by_topic[raw_topic])


def _gather_statuses(message: Any, messages: queue.SimpleQueue[Message], source_count: int) -> None:
    """Add the statuses of other nodes to the first message until every node has published or the timeout expires."""
    statuses = {status.name: status for status in message.status}
    senders = {message._connection_header.get("callerid")}
    deadline = monotonic() + _GATHER_TIMEOUT
    while len(senders) < source_count and (remaining := deadline - monotonic()) > 0:
        try:
            other_message: Any = messages.get(timeout=remaining)
        except queue.Empty:
            break
        senders.add(other_message._connection_header.get("callerid"))
        statuses.update({status.name: status for status in other_message.status})
    message.status = [*statuses.values()]


def _warn_if_unpublished(invocation: Invocation, topic: str) -> None:
    types_by_topic = invocation.graph.published_types()
    if topic in types_by_topic:
        return
    diagnostic_topics = [name for name, type_name in types_by_topic.items() if type_name == _MESSAGE_TYPE]
    hint = (
        f"; these are published: {', '.join(diagnostic_topics)}"
        if diagnostic_topics
        else did_you_mean(topic, types_by_topic)
    )
    print(f"WARNING: topic [{topic}] does not appear to be published yet{hint}", file=sys.stderr, flush=True)


def _print_lines(lines: Sequence[str] | Iterator[str]) -> None:
    for line in lines:
        print(line)


def _local_time(message: Any) -> datetime:
    stamp = message.header.stamp
    return datetime.fromtimestamp(stamp.secs + stamp.nsecs / 1e9, timezone.utc).astimezone()


# Functions without side effects ---------------------------------------------------------------------------------------


def select_statuses(
    statuses: Sequence[Any], lowest_level: int = 1, pattern: re.Pattern[str] | None = None
) -> list[Any]:
    """Return the statuses to print, most severe first.

    Args:
        statuses: the diagnostic_msgs/DiagnosticStatus items of one message. A status that is the parent of another, as
            ``/a`` is of ``/a/b``, only summarizes others and is left out.
        lowest_level: the lowest level to print.
        pattern: a regular expression that must match somewhere in the name.
    """
    parents = {status.name.rpartition("/")[0] for status in statuses}
    statuses_to_print = [
        status
        for status in statuses
        if status.name not in parents
        and status.level >= lowest_level
        and (pattern is None or pattern.search(status.name))
    ]
    return sorted(statuses_to_print, key=lambda status: -status.level)


def status_lines(
    message: Any, statuses: Sequence[Any], *, detail: bool = False, coloured: bool = False
) -> Iterator[str]:
    """Yield the lines to print for statuses.

    Args:
        message: the diagnostic_msgs/DiagnosticArray that contains the statuses.
        statuses: the result of `select_statuses`.
        detail: whether to add time, hardware and values.
        coloured: whether to use escape sequences for colours.
    """
    for status in statuses:
        is_known = 0 <= status.level < len(LEVELS)
        label = _LEVEL_LABELS[status.level] if is_known else f"{status.level:<5}"
        if coloured and is_known:
            label = f"{_COLOURS[status.level]}{label}{_RESET}"
        yield f"[ {label} ] {one_line(status.name)} - {one_line(status.message)}"
        if detail:
            yield f"    timestamp:   {_local_time(message)}"
            yield f"    hardware_id: {one_line(status.hardware_id)}"
            yield from (f"    - {one_line(pair.key)}: {one_line(pair.value)}" for pair in status.values)


def as_json(message: Any, statuses: Sequence[Any]) -> dict[str, Any]:
    """Return statuses as a JSON object: the time in seconds, and each status's level, name, text, hardware, values."""
    return {
        "stamp": message.header.stamp.secs + message.header.stamp.nsecs / 1e9,
        "status": [
            {
                "level": LEVELS[status.level] if 0 <= status.level < len(LEVELS) else status.level,
                "name": status.name,
                "message": status.message,
                "hardware_id": status.hardware_id,
                "values": {pair.key: pair.value for pair in status.values},
            }
            for status in statuses
        ],
    }
