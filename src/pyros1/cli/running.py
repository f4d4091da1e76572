"""Runs a command: finds its verb, parses its arguments, and turns errors into messages and exit codes (L02-L04)."""

from __future__ import annotations

import sys

from pyros1.cli import registry
from pyros1.cli.failures import (
    EX_USAGE,
    CommandError,
    UsageError,
    did_you_mean,
    flush_stdout,
    ignore_closed_pipe,
    other_commands_hint,
    report_no_master,
)
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import parse_args
from pyros1.cli.records import Command, Verb
from pyros1.ground.errors import Error, MasterUnreachableError


def run_command(name: str, argv: list[str]) -> int:
    """Run an existing command.

    Args:
        name: the command's name.
        argv: the arguments after the name.

    Returns:
        The exit code.
    """
    command = registry.load_command(name)
    verb = command.verb
    invocation = Invocation(name, command.stock, argv, with_verb=verb is None and command.dispatch is None)
    if verb is None and command.dispatch is None:
        verb_name = registry.find_verb(name, invocation.verb)
        if verb_name is None:
            help_verb = _requested_help_verb(command, invocation)
            return run_command(name, [help_verb, "-h"]) if help_verb else print_unknown_verb(command, invocation)
        verb = registry.load_verb(name, verb_name)
    try:
        if verb is not None:
            return run_verb(verb, invocation)
        assert command.dispatch is not None
        return command.dispatch(invocation) or 0
    except BrokenPipeError:
        return ignore_closed_pipe()
    except MasterUnreachableError as error:
        return report_no_master(error, command.error_exit_code)
    except (Error, OSError) as error:
        return _print_error(command, error)


def _print_error(command: Command, error: Error | OSError) -> int:
    """Print an error in the command's format and return the exit code.

    Raises:
        OSError: the command has no format for this error.
    """
    message = command.format_error(error) if command.format_error else None
    code = error.code if isinstance(error, CommandError) else command.error_exit_code
    if message is None and not isinstance(error, Error):
        raise error
    flush_stdout()
    plain = isinstance(error, CommandError) and error.plain
    print(message or (str(error) if plain else f"ERROR: {error}"), file=sys.stderr)
    return code


def run_verb(verb: Verb, invocation: Invocation) -> int:
    """Parse the arguments of an invocation and run a verb with them. Return the exit code."""
    try:
        options, arguments = (verb.parse or parse_args)(invocation, verb)
        code = verb.run(invocation, options, arguments)
        sys.stdout.flush()
        return code or 0
    except UsageError as error:
        from pyros1.cli.help import Parser  # noqa: PLC0415 - only needed after a failure

        Parser(verb, invocation).error(str(error))
    finally:
        invocation.close()


def verb_list(command: Command, program: str, *, as_stock: bool) -> str:
    """Return the list of a command's verbs.

    Args:
        command: the command.
        program: the name by which the command was called.
        as_stock: whether to list only the stock tool's verbs with its descriptions.
    """
    lines = [command.heading.format(program=program)]
    verbs = registry.verbs(command.name)
    for name in command.sorted(verbs):
        entry = verbs[name]
        about = entry.stock_about if as_stock else entry.about
        if about and (entry.in_stock_tool or not as_stock):
            lines.append(command.row.format(program=program, name=name, about=about, usage=entry.usage))
    return "\n".join([*lines, command.footer.format(program=program)])


def _requested_help_verb(command: Command, invocation: Invocation) -> str | None:
    """Return the verb in a request for help such as ``topic help echo``; None for other arguments."""
    if not invocation.args or invocation.verb not in command.help_words(as_stock=invocation.as_stock):
        return None
    return registry.find_verb(command.name, invocation.args[0])


def print_unknown_verb(command: Command, invocation: Invocation) -> int:
    """Print the list of verbs and, unless help was requested, an error. Return the exit code."""
    print(verb_list(command, invocation.program, as_stock=invocation.as_stock))
    if invocation.verb in command.help_words(as_stock=invocation.as_stock):
        return 0
    hint = (not invocation.as_stock and other_commands_hint(invocation.verb)) or did_you_mean(
        invocation.verb, registry.verbs(command.name)
    )
    if not hint and not (invocation.verb and (not invocation.as_stock or command.prints_unknown_verb)):
        return command.usage_exit_code
    flush_stdout()
    print(f"{invocation.program}: unknown command {invocation.verb!r}{hint}", file=sys.stderr)
    return command.usage_exit_code if invocation.as_stock else command.usage_exit_code or EX_USAGE
