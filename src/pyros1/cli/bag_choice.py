"""Options that say which messages of a bag are wanted."""

from __future__ import annotations

from optparse import OptionParser, Values

from pyros1.bag.edit import Choice
from pyros1.bag.reader import BagReader
from pyros1.cli.bag_files import parse_time


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
        CommandError: a time is none.
    """
    begin = None if options.begin is None else parse_time(options.begin, bag, "--from")
    end = None if options.end is None else parse_time(options.end, bag, "--to")
    return Choice(_words(options.topics), begin, end, frozenset(_words(options.drop_connections)))


def chosen(options: Values) -> bool:
    """Tell whether any of the options was given."""
    return any((options.topics, options.begin, options.end, options.drop_connections))


def _words(texts: list[str] | None) -> list[str]:
    return [word for text in texts or () for word in text.split(",") if word]
