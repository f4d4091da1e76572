"""The option parser made from a verb's record, and the layout of its help."""

from __future__ import annotations

from optparse import SUPPRESS_HELP, HelpFormatter, IndentedHelpFormatter, OptionParser
from typing import NoReturn

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb

_UNKNOWN = "no such option: "
"""How optparse begins its error."""


class Parser(OptionParser):
    """Parses a verb's words as its record describes.

    Args:
        verb: the record.
        invocation: how the command was called: under the stock tool's name the help is like that tool's.
    """

    def __init__(self, verb: Verb, invocation: Invocation) -> None:
        self._as_stock = stock = invocation.as_stock
        self._examples = verb.examples_text(invocation.program, as_stock=stock)
        usage = " ".join(filter(None, ["usage: %prog", verb.name, verb.usage]))
        super().__init__(
            usage=usage, prog=invocation.program, formatter=_Formatter(), description=verb.description or None
        )
        for option in verb.options:
            text = SUPPRESS_HELP if option.hidden or (option.own and stock) else option.help
            self.add_option(*option.names, help=text, **option.settings)

    def error(self, msg: str) -> NoReturn:
        """Print the usage and an error (for an unknown option, with the one probably meant), and exit with 2."""
        if msg.startswith(_UNKNOWN) and not self._as_stock:
            from pyros1.ground.suggest import did_you_mean  # noqa: PLC0415 - only needed after a failure

            visible = [option for option in self.option_list if option.help != SUPPRESS_HELP]
            known = [name for option in visible for name in option._long_opts]
            msg += did_you_mean(msg.removeprefix(_UNKNOWN), known)
        super().error(msg)

    def format_epilog(self, formatter: HelpFormatter) -> str:
        """Return the examples."""
        return self._examples


class _Formatter(IndentedHelpFormatter):
    """Formats help without the room that optparse's formatter leaves for hidden options."""

    def store_option_strings(self, parser: OptionParser) -> None:
        """Measure the visible options."""
        everything = parser.option_list
        parser.option_list = [option for option in everything if option.help != SUPPRESS_HELP]
        try:
            super().store_option_strings(parser)
        finally:
            parser.option_list = everything
