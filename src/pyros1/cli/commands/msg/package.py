"""``msg package`` (L88, L89)."""

from __future__ import annotations

import os
from functools import partial
from typing import Any

from pyros1.cli.failures import EX_USAGE, UsageError, did_you_mean, fail
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Verb
from pyros1.cli.shared.definitions import JSON_LIST, MESSAGES, Kind, from_stdin, library
from pyros1.cli.shared.printing import print_json


def _run(kind: Kind, invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the types of a package."""
    if len(args) > 1:
        raise UsageError(f"you may only specify one {kind.word} type")  # stock's text, although it is a package
    name = args[0] if args else from_stdin()
    if not library().has_package(name):
        from pyros1.finding.packages import PackageIndex  # noqa: PLC0415 - only what fails needs it

        known = PackageIndex(os.environ).paths()
        if name not in known:
            fail(f"Invalid package: {name}{did_you_mean(name, {*known, *library().packages()})}", EX_USAGE)
    names = kind.names(library(), name)
    if options.json:
        print_json(names)
    else:
        print(*names, sep=" " if options.single_line else "\n")


def make_verb(kind: Kind, *examples: tuple[str, str]) -> Verb:
    """Return the verb for messages or services."""
    return Verb(
        "package",
        f"List {kind.word}s in a package",
        Flag("-s", dest="single_line", help=f"list all {kind.extension}s on a single line"),
        JSON_LIST,
        Argument("package", "package"),
        usage="<package>",
        examples=examples,
        run=partial(_run, kind),
    )


VERB = make_verb(MESSAGES, ("sensor_msgs", "the types of a package"))
