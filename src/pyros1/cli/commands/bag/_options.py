"""Options shared by verbs of ``bag``, for selection and compression, and a parser for times."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from datetime import datetime
from decimal import Decimal, InvalidOperation
from typing import Any

from pyros1.bag.edit.editing import MessageSelection
from pyros1.bag.format.reader import BagReader
from pyros1.bag.format.records import NS_PER_S
from pyros1.cli.failures import CommandError, did_you_mean
from pyros1.cli.records import Flag, Option

QUIET_FLAG = Flag("-q", "--quiet", help="suppress noncritical messages")
TOPICS_OPTION = Option(
    "--topics",
    action="append",
    metavar="T1,T2",
    help="only these topics, separated by commas; * matches any characters. Can be repeated",
)
SELECTION_OPTIONS = (
    TOPICS_OPTION,
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
        help="leave out messages from these publishers, given by node name or by the connection's number in the bag",
    ),
)
"""Options that select messages from a bag, see `make_selection`."""


def compression_options(default: str) -> tuple[Option, Option]:
    """Return the options ``--bz2`` and ``--lz4``. Without them, the compression is `default`."""
    settings: dict[str, Any] = {"action": "store_const", "dest": "compression", "default": default}
    return (
        Option("-j", "--bz2", const="bz2", help="use BZ2 compression", **settings),
        Option("--lz4", const="lz4", help="use lz4 compression", **settings),
    )


def make_selection(options: Any, bag: BagReader) -> MessageSelection:
    """Return the selection that the values of `SELECTION_OPTIONS` describe.

    Args:
        options: The parsed options.
        bag: The bag whose start or end relative times refer to.

    Raises:
        CommandError: A time cannot be parsed, or the start is later than the end.
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


def warn_about_unknown_topics(selection: MessageSelection, bags: Sequence[BagReader]) -> None:
    """Warn about selected topics and connections that no bag contains, since they are probably misspelt."""
    connections = [connection for bag in bags for connection in bag.connections.values()]
    topics = {connection.topic for connection in connections}
    for name in selection.topics:
        if not any(MessageSelection([name]).connections(bag) for bag in bags):
            print(f"WARNING: {name} is not in the bag{did_you_mean(name, topics)}", file=sys.stderr)
    publisher_names = {connection.callerid for connection in connections}
    for name in sorted(selection.drop):
        if name not in publisher_names and name not in {str(connection.id) for connection in connections}:
            print(
                f"WARNING: the bag has no connection from {name}{did_you_mean(name, publisher_names)}", file=sys.stderr
            )


def split_on_commas(values: list[str] | None) -> list[str]:
    """Return all items of a repeatable option whose values are comma-separated lists."""
    return [item for value in values or () for item in value.split(",") if item]


def parse_time(text: str, bag: BagReader | None, option_name: str) -> int:
    """Parse a time from the command line. Return it in nanoseconds.

    Args:
        text: Seconds from the start of the bag, or from its end if negative; ``@`` and seconds since 1970; or a
            local date and time such as ``2026-11-20T20:10:31``.
        bag: The bag whose start or end a relative time refers to; None to return a relative time unchanged.
        option_name: The name of the option, for error messages.

    Raises:
        CommandError: The time has none of these forms.
    """
    try:
        if text.startswith("@"):
            return int(Decimal(text[1:]) * NS_PER_S)
        try:
            offset = int(Decimal(text) * NS_PER_S)
        except InvalidOperation:
            return round(datetime.fromisoformat(text).timestamp() * 1e6) * 1000
    except (InvalidOperation, ValueError, OverflowError):
        raise CommandError(
            f"{option_name}: {text!r} is not a time: give seconds from the start of the bag (negative: from its end), "
            "@ followed by seconds since 1970, or a date such as 2026-11-20T20:10:31",
            2,
        ) from None
    if bag is None:
        return offset
    return (bag.end if text.startswith("-") else bag.start) + offset
