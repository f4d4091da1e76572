"""Parses words with argparse, for commands whose stock tool does so, so that help looks the same.

The settings of `records.Option` are valid for optparse and argparse.
"""

from __future__ import annotations

from argparse import SUPPRESS, ArgumentParser, RawDescriptionHelpFormatter
from typing import Any

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Option, Verb

_COUNTS = {(False, False): None, (False, True): "?", (True, False): "+", (True, True): "*"}
"""(may be repeated, may be left out) -> ``nargs``."""


def make_parser(invocation: Invocation, verb: Verb) -> ArgumentParser:
    """Return a parser for a verb, still without options and arguments."""
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
        invocation: how the command was called: under the stock tool's name help shows only that tool's options.
        parts: options and arguments of the record.
    """
    for part in parts:
        if isinstance(part, Option):
            hidden = part.hidden or (part.own and invocation.as_stock)
            parser.add_argument(*part.names, help=SUPPRESS if hidden else part.help, **part.settings)
        else:
            parser.add_argument(part.name, help=part.help or None, nargs=_COUNTS[part.many, part.optional])
