"""``pyros1 diagnostic``: rosdiagnostic (L202, https://wiki.ros.org/rosdiagnostic)."""

from __future__ import annotations

import queue
import re
import sys
from collections.abc import Iterator, Sequence
from datetime import datetime, timezone
from typing import TYPE_CHECKING, Any

from pyros1.cli.common import CommandError, Invocation, did_you_mean, print_json, run, use_colour
from pyros1.cli.usage import examples_text
from pyros1.shown import one_line

if TYPE_CHECKING:
    import argparse

    from pyros1.msgs import Message

LEVELS = ["ok", "warn", "error", "stale"]
"""Names of the levels; the position is the number."""
_SHOWN = [" OK  ", "WARN ", "ERROR", "STALE"]
_COLOURS = ["\x1b[92m", "\x1b[93m", "\x1b[91m", "\x1b[94m"]
_RESET = "\x1b[0m"
_WIDTH = 69
_LOOK_FOR_END = 0.2
_TYPE = "diagnostic_msgs/DiagnosticArray"
_EXAMPLES = {
    "%prog": "what is not well",
    "%prog -l ok -d": "everything, with all values",
    "%prog -f --filter battery": "the battery, as it changes",
    "%prog --topic /diagnostics": "where no aggregator runs",
}


def main(argv: list[str]) -> int:
    """Run ``diagnostic ...``; returns the exit code."""
    return run("rosdiagnostic", ["show", *argv], {"show": show}, lambda program: "")


def show(invocation: Invocation) -> None:
    """``diagnostic [-f] [-l LEVEL] [--topic TOPIC] [--filter REGEX] [--nocolor] [-d]``."""
    options = _options(invocation)
    try:
        pattern = re.compile(options.filter)
    except re.error as error:
        raise CommandError(f"{options.filter!r} is not a regular expression: {error}", 2) from None
    topic = invocation.resolve(options.topic)
    colour = not options.nocolor and use_colour(sys.stdout)
    arrived: queue.SimpleQueue[Message] = queue.SimpleQueue()
    with invocation.open_node() as node, node.subscribe(topic, _TYPE, arrived.put):
        _say_if_unpublished(invocation, node.resolve(topic))
        while node.ok():
            try:
                message: Any = arrived.get(timeout=_LOOK_FOR_END)
            except queue.Empty:
                continue
            chosen = selected(message.status, options.level, pattern)
            if options.json:
                print_json(as_json(message, chosen))
            elif options.follow:
                _print(status_lines(message, chosen, detail=options.detail, colour=colour))
            else:
                _print([f"{'=' * _WIDTH}", f"Diagnostics generated on: {_moment(message)}", "-" * _WIDTH])
                _print(status_lines(message, chosen, detail=options.detail, colour=colour))
                _print(["=" * _WIDTH])
            sys.stdout.flush()
            if not options.follow:
                return


def _options(invocation: Invocation) -> argparse.Namespace:
    import argparse  # noqa: PLC0415 - most commands use optparse, as their stock tools do

    stock = invocation.program == invocation.stock
    parser = argparse.ArgumentParser(
        prog=invocation.program,
        description="Print what the robot's parts say of their state.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=None if stock else examples_text(invocation.program, _EXAMPLES).lstrip(),
    )
    add = parser.add_argument
    levels = ", ".join(f"{number} {name}" for number, name in enumerate(LEVELS))
    add("-f", "--follow", action="store_true", help="go on printing what comes")
    add("-l", "--level", type=_level, default=1, metavar="LEVEL", help=f"lowest level to print: {levels} (default: 1)")
    add("--topic", default="/diagnostics_agg", help="topic to read (default: %(default)s)")
    add("--filter", default=".*", metavar="REGEX", help="only of names in which this occurs")
    add("--nocolor", action="store_true", help="output without color, also on a terminal")
    add("-d", "--detail", action="store_true", help="print time, hardware and all values, too")
    add("--json", action="store_true", help=argparse.SUPPRESS if stock else "print a line of JSON")
    return parser.parse_args(invocation.args)


def _level(text: str) -> int:
    from argparse import ArgumentTypeError  # noqa: PLC0415 - as above

    word = text.lower()
    if word in LEVELS:
        return LEVELS.index(word)
    numbers = {str(number): number for number in range(len(LEVELS))}
    if word not in numbers:
        levels = ", ".join(f"{number} {name}" for number, name in enumerate(LEVELS))
        raise ArgumentTypeError(f"there is no level {text!r}{did_you_mean(word, LEVELS)}; there are {levels}")
    return numbers[word]


def _say_if_unpublished(invocation: Invocation, topic: str) -> None:
    types = invocation.graph.published_types()
    if topic in types:
        return
    others = [name for name, kind in types.items() if kind == _TYPE]
    hint = f"; there is {', '.join(others)}" if others else did_you_mean(topic, types)
    print(f"WARNING: topic [{topic}] does not appear to be published yet{hint}", file=sys.stderr, flush=True)


def _print(lines: Sequence[str] | Iterator[str]) -> None:
    for line in lines:
        print(line)


def _moment(message: Any) -> datetime:
    stamp = message.header.stamp
    return datetime.fromtimestamp(stamp.secs + stamp.nsecs / 1e9, timezone.utc).astimezone()


# Pure -----------------------------------------------------------------------------------------------------------------


def selected(statuses: Sequence[Any], lowest: int = 1, pattern: re.Pattern[str] | None = None) -> list[Any]:
    """Return the statuses to show, the worst first.

    Args:
        statuses: diagnostic_msgs/DiagnosticStatus of one message. Those that only sum up others, whose names go on
            behind theirs with a slash, are left out.
        lowest: level below which nothing is shown.
        pattern: what must occur in their names.
    """
    parents = {status.name.rpartition("/")[0] for status in statuses}
    chosen = [
        status
        for status in statuses
        if status.name not in parents and status.level >= lowest and (pattern is None or pattern.search(status.name))
    ]
    return sorted(chosen, key=lambda status: -status.level)


def status_lines(message: Any, statuses: Sequence[Any], *, detail: bool = False, colour: bool = False) -> Iterator[str]:
    """Yield the lines about statuses.

    Args:
        message: the diagnostic_msgs/DiagnosticArray that they are from.
        statuses: what `selected` returned.
        detail: with time, hardware and values.
        colour: with escape sequences.
    """
    for status in statuses:
        known = 0 <= status.level < len(LEVELS)
        shown = _SHOWN[status.level] if known else f"{status.level:<5}"
        if colour and known:
            shown = f"{_COLOURS[status.level]}{shown}{_RESET}"
        yield f"[ {shown} ] {one_line(status.name)} - {one_line(status.message)}"
        if detail:
            yield f"    timestamp:   {_moment(message)}"
            yield f"    hardware_id: {one_line(status.hardware_id)}"
            yield from (f"    - {one_line(each.key)}: {one_line(each.value)}" for each in status.values)


def as_json(message: Any, statuses: Sequence[Any]) -> dict[str, Any]:
    """Return statuses for programs: time in seconds, and of each its level, name, text, hardware and values."""
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
