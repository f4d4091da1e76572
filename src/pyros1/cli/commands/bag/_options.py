"""Options of several verbs of ``bag``: selection of messages, times, and compression."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from datetime import datetime
from decimal import Decimal, InvalidOperation
from typing import Any

from pyros1.bag.edit.editing import MessageSelection
from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.records import NS
from pyros1.cli.failures import CommandError, did_you_mean
from pyros1.cli.records import Flag, Option

QUIET = Flag("-q", "--quiet", help="suppress noncritical messages")
TOPICS = Option(
    "--topics",
    action="append",
    metavar="T1,T2",
    help="only these topics, separated by commas; * matches any characters. Can be repeated",
)
SELECTION_OPTIONS = (
    TOPICS,
    Option(
        "--from",
        dest="begin",
        metavar="TIME",
        help="start at TIME: seconds from the start of the bag, or from its end if negative; "
        "@1795205431.7: seconds since 1970; 2026-11-20T20:10:31: local time",
    ),
    Option("--to", dest="end", metavar="TIME", help="end at TIME, in the same forms as --from"),
    Option(
        "--drop-connections",
        action="append",
        metavar="C1,C2",
        help="leave out messages from these publishers: node names or connection numbers",
    ),
)
"""Options that select messages of a bag, see `selection_of`."""


def compression(default: str) -> tuple[Option, Option]:
    """Return the options ``--bz2`` and ``--lz4``; `default` is the compression without them."""
    settings: dict[str, Any] = {"action": "store_const", "dest": "compression", "default": default}
    return (
        Option("-j", "--bz2", const="bz2", help="use BZ2 compression", **settings),
        Option("--lz4", const="lz4", help="use lz4 compression", **settings),
    )


def selection_of(options: Any, bag: BagReader) -> MessageSelection:
    """Return what the options of `SELECTION_OPTIONS` select.

    Args:
        options: their values.
        bag: relative times are relative to its start or end.

    Raises:
        CommandError: a time cannot be read, or the start is later than the end.
    """
    begin = None if options.begin is None else parse_time(options.begin, bag, "--from")
    end = None if options.end is None else parse_time(options.end, bag, "--to")
    if begin is not None and end is not None and begin > end:
        raise CommandError(f"--from {options.begin} is later than --to {options.end}", 2)
    return MessageSelection(
        split_on_commas(options.topics), begin, end, frozenset(split_on_commas(options.drop_connections))
    )


def has_selection(options: Any) -> bool:
    """Return whether any option of `SELECTION_OPTIONS` was given."""
    return any((options.topics, options.begin, options.end, options.drop_connections))


def warn_of_unknown_topics(selection: MessageSelection, bags: Sequence[BagReader]) -> None:
    """Warn about selected topics and connections that are in none of the bags: most likely they are misspelt."""
    connections = [one for bag in bags for one in bag.connections.values()]
    topics = {one.topic for one in connections}
    for name in selection.topics:
        if not any(MessageSelection([name]).connections(bag) for bag in bags):
            print(f"WARNING: {name} is not in the bag{did_you_mean(name, topics)}", file=sys.stderr)
    callers = {one.callerid for one in connections}
    for name in sorted(selection.drop):
        if name not in callers and name not in {str(one.id) for one in connections}:
            print(f"WARNING: the bag has no connection from {name}{did_you_mean(name, callers)}", file=sys.stderr)


def split_on_commas(texts: list[str] | None) -> list[str]:
    """Return all words of an option that takes a list separated by commas and can be repeated."""
    return [word for text in texts or () for word in text.split(",") if word]


def parse_time(text: str, bag: BagReader | None, option: str) -> int:
    """Return a time from the command line, in nanoseconds.

    Args:
        text: seconds from the start of the bag, or from its end if negative; ``@`` and seconds since 1970; or a
            local date and time such as ``2026-11-20T20:10:31``.
        bag: the bag; None if only an absolute time makes sense.
        option: named in errors.

    Raises:
        CommandError: the text has none of these forms.
    """
    try:
        if text.startswith("@"):
            return int(Decimal(text[1:]) * NS)
        try:
            offset = int(Decimal(text) * NS)
        except InvalidOperation:
            return round(datetime.fromisoformat(text).timestamp() * 1e6) * 1000
    except (InvalidOperation, ValueError, OverflowError):
        raise CommandError(
            f"{option}: {text!r} is not a time: give seconds from the start of the bag (negative: from its end), "
            "@ followed by seconds since 1970, or a date such as 2026-11-20T20:10:31",
            2,
        ) from None
    if bag is None:
        return offset
    return (bag.end if text.startswith("-") else bag.start) + offset
