"""Conversion of old bags to this system's definitions (https://wiki.ros.org/rosbag/migration)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pyros1.bag.api import Bag
from pyros1.bag.edit.migrate import Migrated, migrations
from pyros1.bag.edit.migration import MessageUpdateRule as _MessageUpdateRule
from pyros1.bag.edit.migration import Migrator
from pyros1.drop_in.missing import missing
from pyros1.msgs import load_message

__getattr__ = missing(
    __name__,
    RuleChain="pyros1 plans its migrations in another way; see pyros1.bag.edit.migration",
    ScaffoldNode="pyros1 plans its migrations in another way; see pyros1.bag.edit.migration",
)


class BagMigrationException(Exception):
    """A bag cannot be converted."""


class MessageMigrator(Migrator):
    """Converts messages by rules.

    Args:
        input_rule_files: paths of rule files (.bmr).
        plugins: accepted for stock's sake; rules of packages are named by the caller.
    """

    def __init__(self, input_rule_files: Sequence[str] = [], plugins: bool = True) -> None:
        super().__init__(load_message)
        for path in input_rule_files:
            self.read_rules(path)


class MessageUpdateRule(_MessageUpdateRule):
    """One step of a migration; rule files derive from it.

    Args:
        migrator: converts the fields.
        location: the file, for error messages.
    """

    def __init__(self, migrator: Any, location: Any) -> None:
        super().__init__(migrator, location)


def checkbag(migrator: Any, inbag: str) -> list[Any]:
    """Return a pair for each type of a bag that differs from this system's: its classes, old and new, and the missing
    rules; an empty list of those means that the type can be converted.
    """
    with Bag(inbag) as bag:
        return [([old, new], steps) for old, new, steps in migrations(bag, migrator)]


def fixbag(migrator: Any, inbag: str, outbag: str) -> bool:
    """Write a bag with converted messages; return False, and write nothing, if rules are missing."""
    return not fixbag2(migrator, inbag, outbag)


def fixbag2(migrator: Any, inbag: str, outbag: str, force: bool = False) -> list[Any]:
    """Write a bag with converted messages.

    Args:
        force: whether to leave messages as they are if rules are missing for them.

    Returns:
        What `checkbag` found and no rule converts, if nothing was written for that.
    """
    lacking = [pair for pair in checkbag(migrator, inbag) if pair[1]]
    if lacking and not force:
        return lacking
    with Bag(inbag) as bag:
        Migrated(bag, migrator).write(outbag, lambda done: None)
    return []
