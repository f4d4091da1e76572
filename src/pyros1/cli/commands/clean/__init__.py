"""``pyros1 clean``: rosclean (L179)."""

from __future__ import annotations

from typing import Any

from pyros1.cli import registry
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import leave_words
from pyros1.cli.records import Command, Verb
from pyros1.cli.shared.argparsing import add_parts, make_parser


def run(invocation: Invocation, options: Any, args: list[str]) -> int | None:
    """Run ``check`` or ``purge``."""
    parser = make_parser(invocation, _VERB)
    verbs = parser.add_subparsers(required=True, dest="{check,purge}")
    for name in registry.verbs("clean"):
        verb = registry.load_verb("clean", name)
        parser_of_verb = verbs.add_parser(name, help=verb.about)
        add_parts(parser_of_verb, invocation, *verb.options)
        parser_of_verb.set_defaults(verb=verb)
    values = parser.parse_args(invocation.argv)
    code: int | None = values.verb.run(invocation, values, [])
    return code


_VERB = Verb(
    "",
    "",
    examples=[
        ("check", "how much is there"),
        ("purge", "remove all, after a question; what running programs write to is kept"),
        ("purge -y --size 500", "remove the oldest, until 500 MB are left"),
    ],
    parse=leave_words,
    run=run,
)

COMMAND = Command(
    "clean",
    "show and remove log files",
    _VERB,
    group="machine",
    stock="rosclean",
)
