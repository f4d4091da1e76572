"""``pyros1 diagnostic``: rosdiagnostic (L202, https://wiki.ros.org/rosdiagnostic)."""

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
from pyros1.cli.shared.printing import print_json, use_colour
from pyros1.ground.terminal_text import one_line

if TYPE_CHECKING:
    from pyros1.msgs import Message

LEVELS = ["ok", "warn", "error", "stale"]
"""Names of the levels, each at the index of its number."""
_NUMBERED = ", ".join(f"{number} {name}" for number, name in enumerate(LEVELS))
_LEVEL_LABELS = [" OK  ", "WARN ", "ERROR", "STALE"]
_COLOURS = ["\x1b[92m", "\x1b[93m", "\x1b[91m", "\x1b[94m"]
_RESET = "\x1b[0m"
_WIDTH = 69
_POLL_PERIOD = 0.2
_AGGREGATED, _RAW = "/diagnostics_agg", "/diagnostics"
_GATHER_TIMEOUT = 2.0
"""Seconds to wait for all nodes: most publish once a second."""
_TYPE = "diagnostic_msgs/DiagnosticArray"


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the diagnostics that are not OK."""
    try:
        pattern = re.compile(options.filter)
    except re.error as error:
        raise CommandError(f"{options.filter!r} is not a regular expression: {error}", 2) from None
    topic, sources = _topic(invocation, options.topic)
    colour = not options.nocolor and use_colour(sys.stdout)
    arrived: queue.SimpleQueue[Message] = queue.SimpleQueue()
    with invocation.open_node() as node, node.subscribe(topic, _TYPE, arrived.put):
        _warn_if_unpublished(invocation, node.resolve(topic))
        while node.ok():
            try:
                message: Any = arrived.get(timeout=_POLL_PERIOD)
            except queue.Empty:
                continue
            if sources > 1 and not options.follow:
                _gather(message, arrived, sources)
            selected_statuses = selected(message.status, options.level, pattern)
            if options.json:
                print_json(as_json(message, selected_statuses))
            elif options.follow:
                _print(status_lines(message, selected_statuses, detail=options.detail, colour=colour))
            else:
                _print([f"{'=' * _WIDTH}", f"Diagnostics generated on: {_local_time(message)}", "-" * _WIDTH])
                _print(status_lines(message, selected_statuses, detail=options.detail, colour=colour))
                _print(["=" * _WIDTH])
            sys.stdout.flush()
            if not options.follow:
                return


def _parse(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    from pyros1.cli.shared.argparsing import add_parts, make_parser  # noqa: PLC0415 - not needed for completion

    parser = make_parser(invocation, verb)
    add_parts(parser, invocation, *verb.options)
    options = parser.parse_args(invocation.args)
    word = str(options.level).lower()
    if word in LEVELS:
        options.level = LEVELS.index(word)
    elif word in {str(number) for number in range(len(LEVELS))}:
        options.level = int(word)
    else:
        hint = did_you_mean(word, LEVELS)
        parser.error(f"argument -l/--level: unknown level {options.level!r}{hint}; levels: {_NUMBERED}")
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
            help=f"lowest level to print: {_NUMBERED} (default: 1)",
        ),
        Option("--topic", default="", help=f"topic to read (default: {_AGGREGATED}; without an aggregator {_RAW})"),
        Option("--filter", default=".*", metavar="REGEX", help="only names that match this regular expression"),
        Flag("--nocolor", help="no color, even on a terminal"),
        Flag("-d", "--detail", help="also print time, hardware and all values"),
        Flag("--json", help="print a line of JSON", own=True),
        description="Print the diagnostics of the robot's components.",
        examples=[
            ("", "warnings and errors"),
            ("-l ok -d", "everything, with all values"),
            ("-f --filter battery", "follow the state of the battery"),
            ("--topic /diagnostics", "as the nodes send them"),
        ],
        parse=_parse,
        run=run,
    ),
    group="look",
    stock="rosdiagnostic",
)


def _topic(invocation: Invocation, named: str) -> tuple[str, int]:
    """Return the topic to read and the number of nodes whose messages together are the state of the robot.

    If none is named and nothing aggregates diagnostics, as on many robots, the topic of the nodes themselves is read.
    """
    topic = invocation.resolve(named or _AGGREGATED)
    raw = invocation.resolve(_RAW)
    if named or invocation.as_stock:
        return topic, 1
    published = invocation.graph.state().publishers
    if published.get(topic) or not published.get(raw):
        return topic, 1
    print(f"nothing publishes {topic}, so this shows {raw}, as the nodes send them", file=sys.stderr, flush=True)
    return raw, len(published[raw])


def _gather(message: Any, arrived: queue.SimpleQueue[Message], sources: int) -> None:
    """Add the statuses of other nodes to the first message, until all nodes have sent some or a timeout expires."""
    statuses = {status.name: status for status in message.status}
    senders = {message._connection_header.get("callerid")}
    deadline = monotonic() + _GATHER_TIMEOUT
    while len(senders) < sources and (remaining := deadline - monotonic()) > 0:
        try:
            other: Any = arrived.get(timeout=remaining)
        except queue.Empty:
            break
        senders.add(other._connection_header.get("callerid"))
        statuses.update({status.name: status for status in other.status})
    message.status = [*statuses.values()]


def _warn_if_unpublished(invocation: Invocation, topic: str) -> None:
    types = invocation.graph.published_types()
    if topic in types:
        return
    others = [name for name, kind in types.items() if kind == _TYPE]
    hint = f"; these are published: {', '.join(others)}" if others else did_you_mean(topic, types)
    print(f"WARNING: topic [{topic}] does not appear to be published yet{hint}", file=sys.stderr, flush=True)


def _print(lines: Sequence[str] | Iterator[str]) -> None:
    for line in lines:
        print(line)


def _local_time(message: Any) -> datetime:
    stamp = message.header.stamp
    return datetime.fromtimestamp(stamp.secs + stamp.nsecs / 1e9, timezone.utc).astimezone()


# Pure -----------------------------------------------------------------------------------------------------------------


def selected(statuses: Sequence[Any], lowest: int = 1, pattern: re.Pattern[str] | None = None) -> list[Any]:
    """Return the statuses to print, worst first.

    Args:
        statuses: diagnostic_msgs/DiagnosticStatus of one message. A status whose name, followed by a slash, begins
            another's name only summarizes others and is left out.
        lowest: the lowest level to print.
        pattern: a regular expression that must match somewhere in the name.
    """
    parents = {status.name.rpartition("/")[0] for status in statuses}
    selected_statuses = [
        status
        for status in statuses
        if status.name not in parents and status.level >= lowest and (pattern is None or pattern.search(status.name))
    ]
    return sorted(selected_statuses, key=lambda status: -status.level)


def status_lines(message: Any, statuses: Sequence[Any], *, detail: bool = False, colour: bool = False) -> Iterator[str]:
    """Yield the lines of text for statuses.

    Args:
        message: the diagnostic_msgs/DiagnosticArray that contains them.
        statuses: the result of `selected`.
        detail: also print time, hardware and values.
        colour: use escape sequences.
    """
    for status in statuses:
        known = 0 <= status.level < len(LEVELS)
        shown = _LEVEL_LABELS[status.level] if known else f"{status.level:<5}"
        if colour and known:
            shown = f"{_COLOURS[status.level]}{shown}{_RESET}"
        yield f"[ {shown} ] {one_line(status.name)} - {one_line(status.message)}"
        if detail:
            yield f"    timestamp:   {_local_time(message)}"
            yield f"    hardware_id: {one_line(status.hardware_id)}"
            yield from (f"    - {one_line(each.key)}: {one_line(each.value)}" for each in status.values)


def as_json(message: Any, statuses: Sequence[Any]) -> dict[str, Any]:
    """Return statuses for JSON: the time in seconds, and each status with level, name, text, hardware and values."""
    return {
        "stamp": message.header.stamp.secs + message.header.stamp.nsecs / 1e9,
        "status": [
            {
                "level": LEVELS[status.level] if 0 <= status.level < len(LEVELS) else status.level,
                "name": status.name,
                "message": status.message,
                "hardware_id": status.hardware_id,
                "values": {each.key: each.value for each in status.values},
            }
            for status in statuses
        ],
    }
