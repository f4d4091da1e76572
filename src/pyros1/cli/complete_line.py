"""A command line that is being typed."""

from __future__ import annotations

import os

from pyros1.cli import registry

PATIENCE = 0.7
"""Timeout of completion in seconds."""


class Line:
    """A command line with the cursor in it.

    Args:
        words: the words up to the cursor; the last is the one to complete.
        one_line: whether a candidate must fit on one line.
    """

    def __init__(self, words: list[str], one_line: bool = False) -> None:
        self.one_line = one_line
        called, *rest = words
        self.token = rest[-1] if rest else ""
        before = rest[:-1]
        name = os.path.basename(called)
        if name in registry.SHELL_FUNCTIONS:
            before = ["pkg", "cd", *before]
        elif name != "pyros1":
            before = [*registry.stock_names().get(name, ()), *before]
        elif before and before[0] in (stock_names := registry.stock_names()):
            before = [*stock_names[before[0]], *before[1:]]
        self.command = (registry.command_name(before[0]) or before[0]) if before else ""
        self.verbs = [*registry.verbs(self.command)]
        self.words = [word for word in before[1:] if not word.startswith("-") and ":=" not in word]
        self.options = [word for word in before[1:] if word.startswith("-")]

    @property
    def verb(self) -> str:
        """The verb, if the command has verbs."""
        return registry.find_verb(self.command, self.words[0]) or "" if self.words and self.verbs else ""

    @property
    def given(self) -> list[str]:
        """The words after the command and its verb."""
        return self.words[1:] if self.verb else self.words
