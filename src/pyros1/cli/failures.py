"""How a command fails, and what it prints then."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import NoReturn

from pyros1.cli import output
from pyros1.ground.errors import Error, MasterUnreachableError

EX_USAGE = 64
"""Exit code for a missing or unknown verb (sysexits.h), as in the stock tools."""
_MAX_COMMANDS_SHOWN = 3


class CommandError(Error):
    """Ends a command with a text and an exit code.

    Args:
        text: printed to stderr, after "ERROR: " unless ``plain``.
        code: the exit code.
        plain: print the text without "ERROR: ".
    """

    def __init__(self, text: str, code: int = 1, *, plain: bool = False) -> None:
        self.code = code
        self.plain = plain
        super().__init__(text)


class UsageError(Error):
    """The command line is wrong: usage and the text are printed. The exit code is 2."""


def fail(text: str, code: int = 1) -> NoReturn:
    """Raise an error that ends the command with this text, printed without "ERROR: "."""
    raise CommandError(text, code, plain=True)


def report(text: str, code: int) -> int:
    """Print an error. Return the exit code."""
    flush()
    print(f"ERROR: {text}", file=sys.stderr)
    return code


def no_master(error: MasterUnreachableError, code: int) -> int:
    """Print that the master does not answer, like stock, with address, reason and a hint. Return the exit code."""
    return report(f"Unable to communicate with master!\n{error}", code)


def flush() -> None:
    """Flush stdout, so that it comes before an error's text. A closed pipe is ignored."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        quiet_pipe()


def quiet_pipe() -> int:
    """Let the interpreter exit silently after the reader of our output has closed the pipe."""
    output.abandon()
    return 0


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return a suggestion for a misspelt word, to append to a message; empty if nothing is similar."""
    from pyros1.ground.suggest import did_you_mean as hint  # noqa: PLC0415 - only needed after a failure

    return hint(word, known)


def other_commands_hint(verb: str) -> str:
    """Return a hint about other commands with this verb, for example a tool of topic_tools typed after ``topic``."""
    from pyros1.cli import registry  # noqa: PLC0415 - only needed after a failure
    from pyros1.ground.suggest import SYNONYMS  # noqa: PLC0415

    commands_with_verb = [f"'pyros1 {name} {verb}'" for name in registry.commands() if verb in registry.verbs(name)]
    return (
        f" (did you mean {' or '.join(commands_with_verb)}?)"
        if 1 <= len(commands_with_verb) <= _MAX_COMMANDS_SHOWN and verb not in SYNONYMS
        else ""
    )
