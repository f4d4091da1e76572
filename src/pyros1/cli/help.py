"""The option parser that a verb's record makes, and the layout of its help."""

from __future__ import annotations

from optparse import SUPPRESS_HELP, HelpFormatter, IndentedHelpFormatter, OptionParser

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb


class Parser(OptionParser):
    """Parses a verb's words, as its record says.

    Args:
        verb: the record.
        invocation: says how the command was called: under the stock tool's name help is like that tool's.
    """

    def __init__(self, verb: Verb, invocation: Invocation) -> None:
        stock = invocation.as_stock
        self._examples = verb.examples_text(invocation.program, as_stock=stock)
        usage = " ".join(filter(None, ["usage: %prog", verb.name, verb.usage]))
        super().__init__(
            usage=usage, prog=invocation.program, formatter=_Formatter(), description=verb.description or None
        )
        for option in verb.options:
            text = SUPPRESS_HELP if option.hidden or (option.own and stock) else option.help
            self.add_option(*option.names, help=text, **option.settings)

    def format_epilog(self, formatter: HelpFormatter) -> str:
        """Return the examples."""
        return self._examples


class _Formatter(IndentedHelpFormatter):
    """Lays help out as if hidden options were not there; optparse's own leaves room for them."""

    def store_option_strings(self, parser: OptionParser) -> None:
        """Measure the options that are shown."""
        everything = parser.option_list
        parser.option_list = [option for option in everything if option.help != SUPPRESS_HELP]
        try:
            super().store_option_strings(parser)
        finally:
            parser.option_list = everything
