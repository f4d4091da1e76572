"""Analyses an unfinished command line for completion."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from pyros1.cli import registry

if TYPE_CHECKING:
    from pyros1.cli.records import Option

MASTER_TIMEOUT = 0.7
"""Time in seconds after which completion gives up waiting for the master."""


class CommandLine:
    """An unfinished command line, split into command, verb, arguments and the word to complete.

    Args:
        words: the words up to the cursor, starting with the program. The last one is to be completed.
        one_line: whether candidates must not contain line breaks.

    Attributes:
        token: the word to complete.
        command: the name of the command; empty if it is the word to complete.
        verbs: the verbs of the command.
        words: the words between the command and the word to complete, without options and remappings.
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
        self._words_after_command = words_before[1:]

    @property
    def verb(self) -> str:
        """The name of the verb; empty if the command has no verbs or the verb is unknown."""
        return registry.find_verb(self.command, self.words[0]) or "" if self.words and self.verbs else ""

    @property
    def positional_arguments(self) -> list[str]:
        """The positional arguments after the command and its verb."""
        arguments, valued_options, expects_value = [], self._options_with_values(), False
        for word in self._words_after_command:
            if expects_value or word.startswith("-") or ":=" in word:
                expects_value = not expects_value and word in valued_options
            else:
                arguments.append(word)
        return arguments[1:] if self.verb else arguments

    @property
    def option(self) -> Option | None:
        """The option whose value is at the cursor; None if the word to complete is not an option's value."""
        return self._options_with_values().get(self._words_after_command[-1]) if self._words_after_command else None

    def _options_with_values(self) -> dict[str, Option]:
        """Return the options that take a value, each under all of its names."""
        if not any(word.startswith("-") for word in self._words_after_command):
            return {}  # avoid loading the verb
        verb = registry.load_verb(self.command, self.verb) if self.verb else registry.load_command(self.command).verb
        return {
            name: option for option in (verb.options if verb else ()) if option.takes_value for name in option.names
        }
