"""Errors for commands to raise, and functions that print errors and suggestions."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import NoReturn

from pyros1.cli import output
from pyros1.ground.errors import Error, MasterUnreachableError

EX_USAGE = 64
"""Exit code for a missing or unknown verb, as in the stock tools. The name is from sysexits.h."""
_MAX_COMMANDS_SHOWN = 3


class CommandError(Error):
    """Ends a command with an error message and an exit code.

    Args:
        message: the message, which is printed to stderr.
        code: the exit code.
        plain: whether to print the message without the prefix "ERROR: ".
    """

    def __init__(self, message: str, code: int = 1, *, plain: bool = False) -> None:
        self.code = code
        self.plain = plain
        super().__init__(message)


class UsageError(Error):
    """The command line is invalid. The usage and the error message are printed, and the exit code is 2."""


def fail(message: str, code: int = 1) -> NoReturn:
    """Raise a CommandError, which ends the command with this message, printed without the prefix "ERROR: "."""
    raise CommandError(message, code, plain=True)


def report_error(message: str, code: int) -> int:
    """Print an error. Return the exit code."""
    flush_stdout()
    print(f"ERROR: {message}", file=sys.stderr)
    return code


def report_no_master(error: MasterUnreachableError, code: int) -> int:
    """Print the stock tools' message for an unreachable master, then details and a hint. Return the exit code."""
    return report_error(f"Unable to communicate with master!\n{error}", code)


def flush_stdout() -> None:
    """Flush stdout, so that its contents precede an error message. Ignore a closed pipe."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        ignore_closed_pipe()


def ignore_closed_pipe() -> int:
    """Prevent an error at exit because the reader closed stdout's pipe. Return exit code 0."""
    output.discard_output()
    return 0


def did_you_mean(word: str, known_words: Iterable[str]) -> str:
    """Return a suggestion to append to a message about a misspelt word; empty if no known word is similar."""
    from pyros1.ground.suggest import did_you_mean as hint  # noqa: PLC0415 - only needed after a failure

    return hint(word, known_words)


def other_commands_hint(verb: str) -> str:
    """Return a hint about the other commands that have this verb: ``topic relay`` should be ``topic_tools relay``."""
    from pyros1.cli import registry  # noqa: PLC0415 - only needed after a failure
    from pyros1.ground.suggest import SYNONYMS  # noqa: PLC0415

    commands_with_verb = [f"'pyros1 {name} {verb}'" for name in registry.commands() if verb in registry.verbs(name)]
    return (
        f" (did you mean {' or '.join(commands_with_verb)}?)"
        if 1 <= len(commands_with_verb) <= _MAX_COMMANDS_SHOWN and verb not in SYNONYMS
        else ""
    )
