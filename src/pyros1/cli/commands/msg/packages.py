"""``msg packages`` (L88)."""

from __future__ import annotations

from functools import partial
from typing import Any

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Flag, Verb
from pyros1.cli.shared.definitions import JSON_LIST, MESSAGES, Kind, library
from pyros1.cli.shared.printing import print_json


def _run(kind: Kind, invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print packages that have message or service types."""
    names = [name for name in library().packages() if kind.names(library(), name)]
    if options.json:
        print_json(names)
    else:
        print(*names, sep=" " if options.single_line else "\n")


def make_verb(kind: Kind) -> Verb:
    """Return the verb for messages or services."""
    return Verb(
        "packages",
        f"List packages that contain {kind.word}s",
        Flag("-s", dest="single_line", help="list all packages on a single line"),
        JSON_LIST,
        usage="",
        examples=[("", f"packages that have {kind.word}s")],
        run=partial(_run, kind),
    )


VERB = make_verb(MESSAGES)
