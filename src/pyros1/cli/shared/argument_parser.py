"""argparse, for verbs whose stock tools use it: it lays out usage, help and errors in a way of its own."""

from __future__ import annotations

import argparse

from pyros1.cli.help import examples_text
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb


def argument_parser(invocation: Invocation, verb: Verb) -> argparse.ArgumentParser:
    """Return a parser with the options of a verb's record; arguments are to be added."""
    called = f"{invocation.program} {verb.name}".rstrip()
    parser = argparse.ArgumentParser(
        prog=called,
        description=verb.description,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="" if invocation.as_stock else examples_text(called, verb.examples).lstrip(),
    )
    for option in verb.options:
        hidden = option.hidden or (option.own and invocation.as_stock)
        parser.add_argument(*option.names, help=argparse.SUPPRESS if hidden else option.help, **option.settings)
    return parser
