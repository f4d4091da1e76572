"""``bag fix``: copies a bag, and migrates its messages to the definitions on this system (L140)."""

from __future__ import annotations

from typing import Any

from pyros1.bag.api import Bag
from pyros1.bag.edit.migrate import MigratedBagWriter, find_migrations, make_migrator, migration_lines
from pyros1.bag.errors import BagError
from pyros1.cli.commands.bag._writing.files import check_different, new_file
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Verb
from pyros1.cli.shared.options import CHUNK_LIMIT_OPTION
from pyros1.cli.shared.progress import Progress


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Copy a bag with its messages migrated to the definitions on this system. Return 1 if rules are missing."""
    if not args:
        raise UsageError("You must pass input and output bag files.")
    if len(args) < 2:
        raise UsageError("You must pass an output bag file.")
    source, target, *rules = args
    if not target.endswith(".bag"):
        raise UsageError("Output file must be a bag file.")
    check_different(source, target)
    migrator = make_migrator(rules)
    with Bag(source, unindexed=False) as bag:
        if not len(bag):
            raise BagError(source, f"the bag has no messages; {target} was not written")
        impossible_migrations = [migration for migration in find_migrations(bag, migrator) if migration[2]]
        if impossible_migrations and not options.force:
            print("Bag could not be migrated.  The following migrations could not be performed:")
            print(*migration_lines(impossible_migrations), sep="\n")
            print(
                f"Try running '{invocation.program} check' to create the necessary rule files "
                f"or run '{invocation.program} fix' with the '--force' option."
            )
            return 1
        with new_file(target) as temporary_path, Progress(target, bag.reader.file.size) as progress:
            MigratedBagWriter(bag, migrator).write(temporary_path, progress)
    print("Bag migrated successfully.")
    return 0


VERB = Verb(
    "fix",
    "migrate a bag's messages to the message definitions on this system",
    CHUNK_LIMIT_OPTION,
    Flag("-n", "--noplugins", help="do not load rulefiles via plugins"),
    Flag("--force", help="proceed with migrations, even if not all rules defined"),
    Argument("INBAG", "bag"),
    Argument("OUTBAG", "file"),
    Argument("EXTRARULES", "file", repeatable=True, optional=True),
    usage="INBAG OUTBAG [EXTRARULES1 EXTRARULES2 ...]",
    description="Repair the messages in a bag file so that it can be played in the current system. "
    "Rule files are Python programs, and are executed.",
    examples=[("old.bag new.bag rules.bmr", "migrate a bag with rules that `bag check -g rules.bmr` wrote")],
    run=run,
)
