"""Runs the command that a command line names, and imports no other."""

from __future__ import annotations

import os
import sys

from pyros1.cli import output, registry
from pyros1.cli.clean_output import clean_output
from pyros1.cli.packages_here import add_packages_here
from pyros1.cli.records import GROUPS
from pyros1.ground import interrupts
from pyros1.ground.errors import Error

_PRINT_OWN_HINTS = frozenset({"run", "launch"})
"""Commands that print hints at misspelt words themselves."""
_OPTIONS_WITH_VALUES = frozenset({"pub", "call", "set", "publish"})
"""Verbs whose words are YAML values, in which ``a:1`` and ``a=1`` have a meaning."""


_MAX_VERBS = 12
"""Maximum number of verbs per command in the list of commands."""


def usage() -> str:
    """Return the text of ``pyros1 help``."""
    lines = ["usage: pyros1 <command> [arguments]"]
    known = registry.commands()
    for group, heading in GROUPS.items():
        lines += ["", f"{heading}:"]
        lines += [f"  {name:11} {_about(name, entry)}" for name, entry in known.items() if entry.group == group]
    lines += ["", "Each takes the arguments of the ROS 1 tool of that name: `pyros1 topic list` is `rostopic list`."]
    lines += ["Type pyros1 <command> -h for more. pyros1 --version shows the version."]
    return "\n".join(lines)


def _about(name: str, entry: registry.CommandEntry) -> str:
    verbs = registry.verbs(name) if entry.verbs else {}
    named = " ".join([*verbs][:_MAX_VERBS])
    also = f" (also: {', '.join(entry.aliases)})" * bool(entry.aliases)
    return entry.about + also + f": {named}" * bool(named) + " ..." * (len(verbs) > _MAX_VERBS)


def dispatch(argv: list[str], alone: bool) -> int:
    """Run a command; see `pyros1.cli.main.entry`.

    Args:
        argv: the command line with the program's name.
        alone: whether this process only runs the command.

    Returns:
        The exit code.
    """
    if alone:
        output.prepare()
    try:
        try:
            with clean_output():
                return _named_command(list(argv))
        finally:
            sys.stdout.flush()  # here, since errors of Python's own flush at exit cannot be caught
    except KeyboardInterrupt:
        if alone:
            interrupts.die_by_signal()
        return interrupts.EXIT_INTERRUPTED
    except BrokenPipeError:
        output.abandon()  # the reader has closed the pipe
        return 0
    except OSError as error:
        if error.filename != output.NAME:
            raise
        output.abandon()
        print(f"ERROR: cannot write to standard output: {error.strerror}", file=sys.stderr)
        return 1


def _named_command(words: list[str]) -> int:
    called = os.path.basename(words[0]) if words else ""
    if called.startswith("ros") and registry.command_name(called):
        words[:1] = ["pyros1", called]
    if len(words) < 2:
        print(usage())
        return 64
    if words[1] == "help" and len(words) > 2:
        words = [words[0], *words[2:], "-h"]
    word = words[1]
    if word in ("-h", "--help", "help"):
        print(usage())
        return 0
    if word in ("--version", "-V"):
        from pyros1 import __version__  # noqa: PLC0415

        print(f"pyros1 {__version__}")
        return 0
    if word == "__complete":
        add_packages_here(os.environ)
        from pyros1.cli.complete import main as complete  # noqa: PLC0415

        return complete(words[2:])
    name = registry.command_name(word)
    if name is None and word in (stock := registry.stock_names()):  # like rviz, which is `web rviz`
        name, *more = stock[word]
        words[2:2] = more
    if name is None:
        from pyros1.cli.failures import did_you_mean, other_commands_hint  # noqa: PLC0415 - only needed after a failure

        hint = other_commands_hint(word) or did_you_mean(word, [*registry.commands(), *registry.stock_names()])
        print(f"pyros1: unknown command {word!r}{hint}; see: pyros1 help", file=sys.stderr)
        return 64
    return _run(name, words[2:])


def _run(command: str, arguments: list[str]) -> int:
    try:
        add_packages_here(os.environ)
        from pyros1.cli.running import run_command  # noqa: PLC0415 - help and completion run nothing

        with interrupts.keyboard_interrupts():
            code = run_command(command, arguments)
        if code:
            _print_suggestion(command, arguments)
        return code
    except SystemExit as end:
        if end.code:  # the command line is invalid
            _print_suggestion(command, arguments)
        raise
    except Error as error:
        print(f"ERROR: {error}", file=sys.stderr)
        return 1
    except MemoryError:
        print("ERROR: not enough memory", file=sys.stderr)
        return 1
    except UnicodeDecodeError as error:
        byte, place = error.object[error.start], error.start
        print(f"ERROR: the input is not UTF-8 text: byte {byte:#04x} at offset {place}", file=sys.stderr)
        return 1
    except OSError as error:
        if error.filename in (None, output.NAME):  # a bug, if the error is not about a file that the user named
            raise
        print(f"ERROR: {error.filename or repr('')}: {error.strerror}", file=sys.stderr)
        return 1


def _print_suggestion(command: str, arguments: list[str]) -> None:
    """After a failure, print hints about words that look like misspelt options or remappings, but not about values."""
    if command in _PRINT_OWN_HINTS:
        return
    from pyros1.ground.suggest import argument_hint, similar_option  # noqa: PLC0415 - only needed after a failure

    values = any(verb in arguments for verb in _OPTIONS_WITH_VALUES)
    for word in arguments:
        may_be_a_value = (values and word[:1] != "_") or os.path.exists(word)
        hint = argument_hint(word) if similar_option(word) or not may_be_a_value else ""
        if hint:
            print(hint, file=sys.stderr)
