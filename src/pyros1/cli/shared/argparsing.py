"""Parses arguments with argparse, for commands whose stock tools use it, so that the help texts look the same.

The settings of `records.Option` are valid for both optparse and argparse.
"""

from __future__ import annotations

from argparse import SUPPRESS, ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Iterable
from typing import Any

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Option, Verb

_NARGS = {(False, False): None, (False, True): "?", (True, False): "+", (True, True): "*"}
"""The value of ``nargs`` for (repeatable, optional)."""


class _Parser(ArgumentParser):
    """Suggests the option that the user probably meant, like `pyros1.cli.help.Parser`."""

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Return the parsed arguments, or exit with an error."""
        parsed, unknown = self.parse_known_args(args, namespace)
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}{self._suggestion(unknown)}")
        return parsed

    def _suggestion(self, unknown: Iterable[str]) -> str:
        from pyros1.ground.suggest import did_you_mean  # noqa: PLC0415 - only needed after a failure

        visible = [action for action in self._actions if action.help != SUPPRESS]
        known = [name for action in visible for name in action.option_strings if name.startswith("--")]
        return next((did_you_mean(word.partition("=")[0], known) for word in unknown if word.startswith("--")), "")


def make_parser(invocation: Invocation, verb: Verb) -> ArgumentParser:
    """Return a parser for a verb, to which options and arguments can be added."""
    return (ArgumentParser if invocation.as_stock else _Parser)(
        prog=f"{invocation.program} {verb.name}".rstrip(),
        description=verb.description or None,
        epilog=verb.examples_text(invocation.program, as_stock=invocation.as_stock).lstrip() or None,
        formatter_class=RawDescriptionHelpFormatter,
    )


def add_options_and_arguments(parser: Any, invocation: Invocation, *parts: Option | Argument) -> None:
    """Add options and arguments to a parser.

    Args:
        parser: the parser, or one of its argument groups.
        invocation: the invocation. If the command was called by the stock tool's name, help shows only that tool's
            options.
        parts: the options and arguments.
    """
    for part in parts:
        if isinstance(part, Option):
            hidden = part.hidden or (part.pyros1_only and invocation.as_stock)
            parser.add_argument(*part.names, help=SUPPRESS if hidden else part.help, **part.settings)
        else:
            parser.add_argument(part.name, help=part.help or None, nargs=_NARGS[part.repeatable, part.optional])
