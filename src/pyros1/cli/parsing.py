"""Parses command lines into options and positional arguments, according to a verb's record.

The `parse` function of a verb's record is one of these functions or a function from the verb's module.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb

_POSITIONAL_MARK = "\0"
"""Prefix of arguments that are positional although they begin with ``-``."""


def parse_args(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Return the options, whose values are attributes, and the positional arguments.

    Raises:
        SystemExit: help (code 0) or a usage error (code 2) was printed.
    """
    return parse_arg_list(invocation, verb, invocation.args)


def parse_all_args(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Parse like `parse_args`, but keep remappings as arguments, for commands without verbs."""
    return parse_arg_list(invocation, verb, invocation.argv)


def parse_without_specials(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Parse like `parse_all_args`, but leave out arguments that begin with ``__``."""
    return parse_arg_list(invocation, verb, [arg for arg in invocation.argv if not arg.startswith("__")])


def parse_with_negative_numbers(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Parse like `parse_args`, but treat negative numbers as arguments instead of options."""
    return parse_marked(invocation, verb, [mark_negative_number(arg) for arg in invocation.args])


def leave_unparsed(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    """Return None and all arguments, for verbs whose `run` parses them.

    The options in the records of such verbs are only used for help and completion.
    """
    return None, invocation.args


def parse_marked(invocation: Invocation, verb: Verb, args: list[str]) -> tuple[Any, list[str]]:
    """Parse arguments like `parse_args`. Those marked by `mark_negative_number` are positional."""
    options, arguments = parse_arg_list(invocation, verb, args)
    return options, [argument.removeprefix(_POSITIONAL_MARK) for argument in arguments]


def mark_negative_number(arg: str) -> str:
    """Return an argument, with a mark that makes it positional if it is a negative number."""
    return _POSITIONAL_MARK + arg if _is_negative_number(arg) else arg


def unmark(arg: str) -> str:
    """Return an argument without the mark of `mark_negative_number`."""
    return arg.removeprefix(_POSITIONAL_MARK)


def default_options(verb: Verb) -> Any:
    """Return an object whose attributes are the default values of the options."""
    return SimpleNamespace(**{option.dest: option.settings.get("default") for option in verb.options})


def parse_arg_list(invocation: Invocation, verb: Verb, args: list[str]) -> tuple[Any, list[str]]:
    """Parse the given arguments like `parse_args`, instead of the invocation's."""
    if not any(arg.startswith("-") for arg in args):  # avoid importing the parser
        return default_options(verb), args
    from pyros1.cli.help import Parser  # noqa: PLC0415

    return Parser(verb, invocation).parse_args(args)


def _is_negative_number(text: str) -> bool:
    if not text.startswith("-"):
        return False
    try:
        float(text)
    except ValueError:
        return False
    return True
