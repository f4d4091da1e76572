"""Options that say which messages of a bag are wanted."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from optparse import OptionParser, Values

from pyros1.bag.edit import Choice
from pyros1.bag.reader import BagReader
from pyros1.cli.bag_files import parse_time
from pyros1.cli.common import CommandError, did_you_mean


def add_choice(parser: OptionParser) -> None:
    """Add ``--topics``, ``--from``, ``--to`` and ``--drop-connections``."""
    parser.add_option(
        "--topics",
        action="append",
        metavar="T1,T2",
        help="only these topics, separated by commas; * stands for any characters. Can be given several times",
    )
    parser.add_option(
        "--from",
        dest="begin",
        metavar="TIME",
        help="only from TIME on: seconds from the beginning of the bag, or from its end if negative; "
        "@1795205431.7: seconds since 1970; 2026-11-20T20:10:31: local time",
    )
    parser.add_option("--to", dest="end", metavar="TIME", help="only until TIME, as for --from")
    parser.add_option(
        "--drop-connections",
        action="append",
        metavar="C1,C2",
        help="leave out what came from these: names of nodes, or numbers of connections",
    )


def choice_of(options: Values, bag: BagReader) -> Choice:
    """Return what the options choose.

    Args:
        bag: the one whose times seconds are counted from.

    Raises:
        CommandError: a time is none, or there is nothing between the times.
    """
    begin = None if options.begin is None else parse_time(options.begin, bag, "--from")
    end = None if options.end is None else parse_time(options.end, bag, "--to")
    if begin is not None and end is not None and begin > end:
        raise CommandError(f"--from {options.begin} is later than --to {options.end}", 2)
    return Choice(_words(options.topics), begin, end, frozenset(_words(options.drop_connections)))


def warn_of_strangers(choice: Choice, bags: Sequence[BagReader]) -> None:
    """Say which of the topics and connections that were named are in none of the bags: misspelt ones, most likely."""
    connections = [one for bag in bags for one in bag.connections.values()]
    topics = {one.topic for one in connections}
    for name in choice.topics:
        if not any(Choice([name]).connections(bag) for bag in bags):
            print(f"WARNING: {name} is not in the bag{did_you_mean(name, topics)}", file=sys.stderr)
    callers = {one.callerid for one in connections}
    for name in sorted(choice.drop):
        if name not in callers and name not in {str(one.id) for one in connections}:
            print(f"WARNING: no connection of the bag is {name}{did_you_mean(name, callers)}", file=sys.stderr)


def chosen(options: Values) -> bool:
    """Tell whether any of the options was given."""
    return any((options.topics, options.begin, options.end, options.drop_connections))


def _words(texts: list[str] | None) -> list[str]:
    return [word for text in texts or () for word in text.split(",") if word]
