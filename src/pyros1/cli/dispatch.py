"""Runs the command named on the command line, without importing the other commands."""

from __future__ import annotations

import os
import sys

from pyros1.cli import output, registry
from pyros1.cli.clean_output import clean_output
from pyros1.cli.nearby_packages import add_nearby_packages
from pyros1.cli.records import COMMAND_GROUPS
from pyros1.ground import interrupts
from pyros1.ground.errors import Error

_COMMANDS_WITH_OWN_HINTS = frozenset({"run", "launch"})
"""Commands that print their own hints about misspelt arguments."""
_VERBS_WITH_VALUES = frozenset({"pub", "call", "set", "publish", "keys"})
"""Verbs whose arguments are YAML values, in which ``a:1`` and ``a=1`` are valid, or sites with host names (``a=b``)."""


_MAX_VERBS = 12
"""Maximum number of verbs listed per command in the list of commands."""


def usage() -> str:
    """Return the text that ``pyros1 help`` prints: how to call pyros1, and all commands by group."""
    lines = ["usage: pyros1 <command> [arguments]"]
    all_commands = registry.commands()
    for group, heading in COMMAND_GROUPS.items():
        lines += ["", f"{heading}:"]
        lines += [
            f"  {name:11} {_command_summary(name, entry)}"
            for name, entry in all_commands.items()
            if entry.group == group
        ]
    lines += ["", "Commands accept the arguments of ROS 1's tools: `pyros1 topic list` does what `rostopic list` does."]
    lines += ["Type pyros1 <command> -h for more. pyros1 --version shows the version."]
    return "\n".join(lines)


def _command_summary(name: str, entry: registry.CommandEntry) -> str:
    verbs = registry.verbs(name) if entry.verbs else {}
    verb_list = " ".join([*verbs][:_MAX_VERBS])
    aliases = f" (also: {', '.join(entry.aliases)})" * bool(entry.aliases)
    return entry.about + aliases + f": {verb_list}" * bool(verb_list) + " ..." * (len(verbs) > _MAX_VERBS)


def dispatch(argv: list[str], alone: bool) -> int:
    """Run a command; see `pyros1.cli.main.entry`.

    Args:
        argv: the command line with the program's name.
        alone: whether the process exists only to run this command. If so, the process's standard streams and signal
            handlers may be changed.

    Returns:
        The exit code.
    """
    if alone:
        output.prepare_streams()
    try:
        try:
            with clean_output():
                return _run_named_command(list(argv))
        finally:
            sys.stdout.flush()  # errors in Python's own flush at exit cannot be caught
    except (KeyboardInterrupt, RuntimeError) as error:
        if not interrupts.is_keyboard_interrupt(error):
            raise
        if alone:
            interrupts.die_by_signal()
        return interrupts.INTERRUPTED_EXIT_CODE
    except BrokenPipeError:
        output.discard_output()  # the reader closed the pipe
        return 0
    except OSError as error:
        if error.filename != output.STDOUT_NAME:
            raise
        output.discard_output()
        print(f"ERROR: cannot write to standard output: {error.strerror}", file=sys.stderr)
        return 1


def _run_named_command(argv: list[str]) -> int:
    program = os.path.basename(argv[0]) if argv else ""
    if program.startswith("ros") and registry.command_name(program):
        argv[:1] = ["pyros1", program]
    if len(argv) < 2:
        print(usage())
        return 64
    if argv[1] == "help" and len(argv) > 2:
        argv = [argv[0], *argv[2:], "-h"]
    first_arg = argv[1]
    if first_arg in ("-h", "--help", "help"):
        print(usage())
        return 0
    if first_arg in ("--version", "-V"):
        from pyros1 import __version__  # noqa: PLC0415

        print(f"pyros1 {__version__}")
        return 0
    if first_arg == "__complete":
        add_nearby_packages(os.environ)
        from pyros1.cli.complete import main as complete  # noqa: PLC0415

        return complete(argv[2:])
    name = registry.command_name(first_arg)
    if name is None and first_arg in (stock_names := registry.stock_names()):  # for example rviz, which is `web rviz`
        name, *args = stock_names[first_arg]
        argv[2:2] = args
    if name is None:
        from pyros1.cli.failures import did_you_mean, other_commands_hint  # noqa: PLC0415 - only needed after a failure

        hint = other_commands_hint(first_arg) or did_you_mean(
            first_arg, [*registry.commands(), *registry.stock_names()]
        )
        print(f"pyros1: unknown command {first_arg!r}{hint}; see: pyros1 help", file=sys.stderr)
        return 64
    return _run_and_report_errors(name, argv[2:])


def _run_and_report_errors(command: str, arguments: list[str]) -> int:
    try:
        add_nearby_packages(os.environ)
        from pyros1.cli.running import run_command  # noqa: PLC0415 - not needed for help and completion

        with interrupts.raise_keyboard_interrupts():
            code = run_command(command, arguments)
        if code:
            _print_argument_hints(command, arguments)
        return code
    except SystemExit as error:
        if error.code:  # the command line is invalid
            _print_argument_hints(command, arguments)
        raise
    except Error as error:
        print(f"ERROR: {error}", file=sys.stderr)
        return 1
    except MemoryError:
        print("ERROR: not enough memory", file=sys.stderr)
        return 1
    except UnicodeDecodeError as error:
        byte, offset = error.object[error.start], error.start
        print(f"ERROR: the input is not UTF-8 text: byte {byte:#04x} at offset {offset}", file=sys.stderr)
        return 1
    except OSError as error:
        if error.filename in (None, output.STDOUT_NAME):  # an error that names no file is a bug
            raise
        print(f"ERROR: {error.filename or repr('')}: {error.strerror}", file=sys.stderr)
        return 1


def _print_argument_hints(command: str, arguments: list[str]) -> None:
    """After a failure, print hints about arguments that look like misspelt options or remappings."""
    if command in _COMMANDS_WITH_OWN_HINTS:
        return
    from pyros1.ground.suggest import argument_hint, similar_option  # noqa: PLC0415 - only needed after a failure

    has_values = any(verb in arguments for verb in _VERBS_WITH_VALUES)
    for argument in arguments:
        may_be_value = (has_values and argument[:1] != "_") or os.path.exists(argument)
        hint = argument_hint(argument) if similar_option(argument) or not may_be_value else ""
        if hint:
            print(hint, file=sys.stderr)
