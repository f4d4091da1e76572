"""The mutants that no test has to notice: ``equivalent.txt`` names each of them with a reason. Pure."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .mutate import Mutant


def name_of(path: object, source: str, mutant: Mutant) -> str:
    """Return the name of a mutant of a module's text that stays the same when its line moves."""
    line = re.split("\r?\n", source)[mutant.line - 1].strip()
    return f"{path} | {line} | {mutant}"


def names_in(text: str) -> dict[str, str]:
    """Return the names in a list of equivalent mutants, each with the comment above it that gives the reason."""
    found: dict[str, str] = {}
    reason: list[str] = []
    before = ""
    for line in text.splitlines():
        if line.startswith("#"):
            reason = [*(reason if before.startswith("#") else []), line.strip("# ")]
        elif line:
            found[line] = " ".join(reason)
        else:
            reason = []
        before = line
    return found
