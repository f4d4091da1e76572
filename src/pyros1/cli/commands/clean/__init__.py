"""``pyros1 clean``: shows and removes log files, like rosclean (L179)."""

from __future__ import annotations

from argparse import ArgumentParser, RawDescriptionHelpFormatter

from pyros1.cli import registry
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Command, examples_block
from pyros1.cli.shared.argparsing import add_options_and_arguments


def _dispatch(invocation: Invocation) -> int | None:
    """Parse the arguments like the stock tool, and run ``check`` or ``purge``. Return the exit code."""
    program, as_stock = invocation.program, invocation.as_stock
    verbs = [registry.load_verb("clean", name) for name in registry.verbs("clean")]
    examples = [(f"{verb.name} {line}".rstrip(), about) for verb in verbs for line, about in verb.examples]
    parser = ArgumentParser(
        prog=program,
        formatter_class=RawDescriptionHelpFormatter,
        epilog=None if as_stock else examples_block(program, examples).lstrip(),
    )
    subparsers = parser.add_subparsers(required=True, dest="{check,purge}")
    for verb in verbs:
        epilog = verb.examples_text(program, as_stock=as_stock).lstrip() or None
        verb_parser = subparsers.add_parser(
            verb.name, help=verb.about, epilog=epilog, formatter_class=RawDescriptionHelpFormatter
        )
        add_options_and_arguments(verb_parser, invocation, *verb.options)
        verb_parser.set_defaults(verb=verb)
    options = parser.parse_args(invocation.argv)
    code: int | None = options.verb.run(invocation, options, [])
    return code


COMMAND = Command("clean", "show and remove log files", group="machine", stock="rosclean", dispatch=_dispatch)
