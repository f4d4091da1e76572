"""An unfinished command line, for completion."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from pyros1.cli import registry

if TYPE_CHECKING:
    from pyros1.cli.records import Option

TIMEOUT = 0.7
"""Timeout of completion in seconds."""


class CommandLine:
    """An unfinished command line.

    Args:
        words: the words up to the cursor. The last one is to be completed.
        one_line: whether candidates must not contain line breaks.
    """

    def __init__(self, words: list[str], one_line: bool = False) -> None:
        self.one_line = one_line
        program, *remaining = words
        self.token = remaining[-1] if remaining else ""
        words_before = remaining[:-1]
        name = os.path.basename(program)
        if name in registry.SHELL_FUNCTIONS:
            words_before = ["pkg", "cd", *words_before]
        elif name != "pyros1":
            words_before = [*registry.stock_names().get(name, ()), *words_before]
        elif words_before and words_before[0] in (stock_names := registry.stock_names()):
            words_before = [*stock_names[words_before[0]], *words_before[1:]]
        self.command = (registry.command_name(words_before[0]) or words_before[0]) if words_before else ""
        self.verbs = [*registry.verbs(self.command)]
        self.words = [word for word in words_before[1:] if not word.startswith("-") and ":=" not in word]
        self._typed = words_before[1:]

    @property
    def verb(self) -> str:
        """The verb if the command has verbs."""
        return registry.find_verb(self.command, self.words[0]) or "" if self.words and self.verbs else ""

    @property
    def positional_arguments(self) -> list[str]:
        """The positional arguments after the command and its verb."""
        arguments, valued_options, is_value = [], self._options_with_values(), False
        for word in self._typed:
            if is_value or word.startswith("-") or ":=" in word:
                is_value = not is_value and word in valued_options
            else:
                arguments.append(word)
        return arguments[1:] if self.verb else arguments

    @property
    def option(self) -> Option | None:
        """The option whose value is at the cursor."""
        return self._options_with_values().get(self._typed[-1]) if self._typed else None

    def _options_with_values(self) -> dict[str, Option]:
        """Return the options that take a value, each under all of its names."""
        if not any(word.startswith("-") for word in self._typed):
            return {}  # avoid loading the verb
        verb = registry.load_verb(self.command, self.verb) if self.verb else registry.load_command(self.command).verb
        return {
            name: option for option in (verb.options if verb else ()) if option.takes_value for name in option.names
        }
