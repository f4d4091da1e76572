"""``msg list`` (L88)."""

from __future__ import annotations

from functools import partial
from typing import Any

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb
from pyros1.cli.shared.definitions import JSON_LIST, MESSAGES, Kind, library
from pyros1.cli.shared.printing import print_json


def _run(kind: Kind, invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print all types."""
    names = [name for package in library().packages() for name in kind.names(library(), package)]
    if options.json:
        print_json(names)
    elif names:
        print(*names, sep="\n")


def make_verb(kind: Kind) -> Verb:
    """Return the verb for messages or services."""
    return Verb(
        "list",
        f"List all {kind.word}s",
        JSON_LIST,
        usage="",
        examples=[("", "all types"), ("--json", "for programs")],
        run=partial(_run, kind),
    )


VERB = make_verb(MESSAGES)
