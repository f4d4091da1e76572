"""Parses arguments with argparse, for commands whose stock tools use it, so that the help texts look the same.

The settings of `records.Option` are valid for both optparse and argparse.
"""

from __future__ import annotations

from argparse import SUPPRESS, ArgumentParser, RawDescriptionHelpFormatter
from typing import Any

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Option, Verb

_NARGS = {(False, False): None, (False, True): "?", (True, False): "+", (True, True): "*"}
"""The value of ``nargs`` for (repeatable, optional)."""


def make_parser(invocation: Invocation, verb: Verb) -> ArgumentParser:
    """Return a parser for a verb, to which options and arguments can be added."""
    return ArgumentParser(
        prog=f"{invocation.program} {verb.name}".rstrip(),
        description=verb.description or None,
        epilog=verb.examples_text(invocation.program, as_stock=invocation.as_stock).lstrip() or None,
        formatter_class=RawDescriptionHelpFormatter,
    )


def add_options_and_arguments(parser: Any, invocation: Invocation, *parts: Option | Argument) -> None:
    """Add options and arguments to a parser.

    Args:
        parser: the parser, or one of its argument groups.
        invocation: the invocation. If the command was called by the stock tool's name, help shows only that tool's
            options.
        parts: the options and arguments.
    """
    for part in parts:
        if isinstance(part, Option):
            hidden = part.hidden or (part.pyros1_only and invocation.as_stock)
            parser.add_argument(*part.names, help=SUPPRESS if hidden else part.help, **part.settings)
        else:
            parser.add_argument(part.name, help=part.help or None, nargs=_NARGS[part.repeatable, part.optional])
