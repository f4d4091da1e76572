"""``bag check``: finds messages that do not match this system's definitions, and writes rules for ``fix`` (L139)."""

from __future__ import annotations

import os
from typing import Any

from pyros1.bag.api import Bag
from pyros1.bag.edit.migrate import Migration, find_migrations, make_migrator, migration_lines
from pyros1.bag.edit.migration import rule_text
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.options import CHUNK_LIMIT_OPTION


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the migrations that a bag's messages need to match this system's definitions. With ``-g``, write rules."""
    if not args:
        raise UsageError("You must specify a bag file to check.")
    if options.append and options.rulefile is None:
        raise UsageError("Cannot specify -a without also specifying -g.")
    if options.rulefile is not None and os.path.isfile(options.rulefile) != options.append:
        reason = "does not exist, and so -a is invalid" if options.append else "already exists. Include -a to append"
        raise UsageError(f"The file {options.rulefile} {reason}.")
    migrator = make_migrator([*args[1:], *([options.rulefile] if options.append else [])])
    with Bag(args[0], unindexed=False) as bag:
        needed_migrations = find_migrations(bag, migrator)
    if not needed_migrations:
        print("Bag file does not need any migrations.")
        return
    print("The following migrations need to occur:")
    print(*migration_lines(needed_migrations), sep="\n")
    print(f"\n{_write_missing_rules(needed_migrations, options.rulefile)}")


VERB = Verb(
    "check",
    "check whether a bag's messages match the message definitions on this system",
    CHUNK_LIMIT_OPTION,
    Option("-g", "--genrules", dest="rulefile", help="generate a rulefile named RULEFILE"),
    Flag("-a", "--append", help="append to the end of an existing rulefile after loading it"),
    Flag("-n", "--noplugins", help="do not load rulefiles via plugins"),
    Argument("BAG", "bag"),
    Argument("EXTRARULES", "file", repeatable=True, optional=True),
    usage="BAG [-g RULEFILE] [EXTRARULES1 EXTRARULES2 ...]",
    description="Determine whether a bag is playable in the current system, or if it can be migrated. "
    "Rule files are Python programs, and are executed.",
    examples=[
        ("old.bag", "print which message types have changed since the bag was recorded"),
        ("-g rules.bmr old.bag", "write migration rules for `bag fix`, to be completed by hand"),
    ],
    run=run,
)


def _write_missing_rules(needed_migrations: list[Migration], path: str | None) -> str:
    """Append the missing rules to a file if one is given. Return the message to print."""
    missing_rules = {
        old_class._md5sum: (old_class, new_class) for _, _, steps in needed_migrations for old_class, new_class in steps
    }
    if path is None and missing_rules:
        return "To generate rules, please run with -g <rulefile>"
    if path is None:
        return "All rules defined.  Bag is ready to be migrated"
    rule_texts = [
        rule_text(old_class, new_class) for old_class, new_class in missing_rules.values() if new_class is not None
    ]
    if not rule_texts:
        return f"No additional rule files needed to be generated.  {path} not created."
    with open(path, "a", encoding="utf-8") as file:
        file.write("".join(rule_texts))
    return f"The necessary rule files have been written to: {path}"
