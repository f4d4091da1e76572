"""Parsing of a command line's words into options and arguments, as a verb's record describes.

A verb's `parse` is one of these functions, or a function of the verb's module.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb

_GUARD = "\0"


def parse_words(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Return the options' values by name, as attributes, and the arguments.

    Raises:
        SystemExit: with code 0 after help, 2 after a usage error. The text has been printed.
    """
    return parse_these(invocation, verb, invocation.args)


def parse_all_words(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Parse like `parse_words`, with words that look like remappings as arguments, for commands without verbs."""
    return parse_these(invocation, verb, invocation.argv)


def parse_without_specials(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Parse like `parse_all_words`, but drop words that begin with ``__``."""
    return parse_these(invocation, verb, [word for word in invocation.argv if not word.startswith("__")])


def parse_with_negative_numbers(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Parse like `parse_words`, with negative numbers as arguments instead of options."""
    return parse_guarded(invocation, verb, [guard(word) for word in invocation.args])


def leave_words(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Return None and all words: the verb parses them itself. The record's options serve help and completion."""
    return None, invocation.args


def parse_guarded(invocation: Invocation, verb: Verb, words: list[str]) -> tuple[Any, list[str]]:
    """Parse words, some of which `guard` has marked as arguments."""
    options, arguments = parse_these(invocation, verb, words)
    return options, [argument.removeprefix(_GUARD) for argument in arguments]


def guard(word: str) -> str:
    """Return a word, marked as an argument if it is a negative number."""
    return _GUARD + word if _is_negative_number(word) else word


def unguard(word: str) -> str:
    """Return a word without the mark of `guard`."""
    return word.removeprefix(_GUARD)


def defaults(verb: Verb) -> Any:
    """Return the options' default values."""
    return SimpleNamespace(**{option.dest: option.settings.get("default") for option in verb.options})


def parse_these(invocation: Invocation, verb: Verb, words: list[str]) -> tuple[Any, list[str]]:
    """Parse like `parse_words`, with other words than the invocation's."""
    if not any(word.startswith("-") for word in words):  # nothing to parse: quick commands need no parser
        return defaults(verb), words
    from pyros1.cli.help import Parser  # noqa: PLC0415

    return Parser(verb, invocation).parse_args(words)


def _is_negative_number(text: str) -> bool:
    if not text.startswith("-"):
        return False
    try:
        float(text)
    except ValueError:
        return False
    return True
