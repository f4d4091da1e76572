"""The words of a command line become options and arguments, as a verb's record says.

A verb's `parse` is one of these functions, or one of its own.
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
        SystemExit: help was asked for (0), or the options are wrong (2); what there is to say has been printed.
    """
    return parse_these(invocation, verb, invocation.args)


def parse_all_words(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Do the same with what looks like remappings, too: these are arguments of a command without verbs."""
    return parse_these(invocation, verb, invocation.argv)


def parse_without_specials(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Do that, but for words that begin with ``__``."""
    return parse_these(invocation, verb, [word for word in invocation.argv if not word.startswith("__")])


def parse_with_negative_numbers(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Do the same where arguments may be negative numbers, which are no options."""
    return parse_guarded(invocation, verb, [guard(word) for word in invocation.args])


def leave_words(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Return None and all words: the verb parses them itself, and the record's options are for help and completion."""
    return None, invocation.args


def parse_guarded(invocation: Invocation, verb: Verb, words: list[str]) -> tuple[Any, list[str]]:
    """Parse words of which some were marked by `guard` as arguments."""
    options, arguments = parse_these(invocation, verb, words)
    return options, [argument.removeprefix(_GUARD) for argument in arguments]


def guard(word: str) -> str:
    """Return a word, marked as no option if it is a negative number."""
    return _GUARD + word if _is_negative_number(word) else word


def unguard(word: str) -> str:
    """Return a word without the mark of `guard`."""
    return word.removeprefix(_GUARD)


def defaults(verb: Verb) -> Any:
    """Return the options' values when none is given."""
    return SimpleNamespace(**{option.dest: option.settings.get("default") for option in verb.options})


def parse_these(invocation: Invocation, verb: Verb, words: list[str]) -> tuple[Any, list[str]]:
    """Do as `parse_words` with other words than the invocation's."""
    if not any(word.startswith("-") for word in words):  # nothing to parse: the quickest commands import no parser
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
