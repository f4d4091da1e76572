"""How a command ends that cannot do what was asked, and what is said then."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import NoReturn

from pyros1.cli import output
from pyros1.errors import Error, MasterUnreachableError

EX_USAGE = 64
"""Exit code of a missing or unknown verb (sysexits.h), as the stock tools'."""
_MOST_HOMES = 3


class CommandError(Error):
    """Ends a command with a text and an exit code.

    Args:
        text: printed to stderr as it is, without "ERROR: " before it if ``plain``.
        code: the exit code.
        plain: see there.
    """

    def __init__(self, text: str, code: int = 1, *, plain: bool = False) -> None:
        self.code = code
        self.plain = plain
        super().__init__(text)


class UsageError(Error):
    """The command line is wrong: usage is printed, then the text; the exit code is 2."""


def fail(text: str, code: int = 1) -> NoReturn:
    """End the command with a text that is printed as it is."""
    raise CommandError(text, code, plain=True)


def report(text: str, code: int) -> int:
    """Print an error and return the exit code."""
    flush()
    print(f"ERROR: {text}", file=sys.stderr)
    return code


def no_master(error: MasterUnreachableError, code: int) -> int:
    """Print that the master does not answer, in stock's words, and where, why and what to do; return the exit code."""
    return report(f"Unable to communicate with master!\n{error}", code)


def flush() -> None:
    """Write out what was printed, so that it stands before an error's text; a closed pipe does not matter any more."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        quiet_pipe()


def quiet_pipe() -> int:
    """After the reader of our output went away: let the interpreter end without complaint."""
    output.abandon()
    return 0


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return a hint at what a misspelt word may mean, to be put behind a message; empty if nothing is near."""
    from pyros1.suggest import did_you_mean as hint  # noqa: PLC0415 - only what fails needs it

    return hint(word, known)


def elsewhere(verb: str) -> str:
    """Return a hint at other commands that have such a verb: the tool of topic_tools sought among those of topics."""
    from pyros1.cli import registry  # noqa: PLC0415 - only what fails needs it
    from pyros1.suggest import SYNONYMS  # noqa: PLC0415

    homes = [f"'pyros1 {name} {verb}'" for name in registry.commands() if verb in registry.verbs(name)]
    return f" (did you mean {' or '.join(homes)}?)" if 1 <= len(homes) <= _MOST_HOMES and verb not in SYNONYMS else ""
