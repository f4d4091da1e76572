"""Parses words with argparse, as a verb's record says: for commands whose stock tool does so, since help looks alike.

What `records.Option` takes for optparse is what argparse takes, too.
"""

from __future__ import annotations

from argparse import SUPPRESS, ArgumentParser, RawDescriptionHelpFormatter
from typing import Any

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Option, Verb

_COUNTS = {(False, False): None, (False, True): "?", (True, False): "+", (True, True): "*"}
"""Whether an argument may be repeated, and left out -> ``nargs``."""


def make_parser(invocation: Invocation, verb: Verb) -> ArgumentParser:
    """Return a parser of a verb that knows none of its options and arguments yet."""
    return ArgumentParser(
        prog=f"{invocation.program} {verb.name}".rstrip(),
        description=verb.description or None,
        epilog=verb.examples_text(invocation.program, as_stock=invocation.as_stock).lstrip() or None,
        formatter_class=RawDescriptionHelpFormatter,
    )


def add_parts(parser: Any, invocation: Invocation, *parts: Option | Argument) -> None:
    """Add options and arguments.

    Args:
        parser: the parser, or a group of it.
        invocation: says how the command was called: under the stock tool's name help leaves out what that lacks.
        parts: of the record.
    """
    for part in parts:
        if isinstance(part, Option):
            hidden = part.hidden or (part.own and invocation.as_stock)
            parser.add_argument(*part.names, help=SUPPRESS if hidden else part.help, **part.settings)
        else:
            parser.add_argument(part.name, help=part.help or None, nargs=_COUNTS[part.many, part.optional])
