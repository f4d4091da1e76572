"""The option parser of verbs, which also prints their usage and help."""

from __future__ import annotations

from optparse import SUPPRESS_HELP, HelpFormatter, IndentedHelpFormatter, OptionParser
from typing import NoReturn

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb

_UNKNOWN_OPTION_PREFIX = "no such option: "
"""The prefix of optparse's error message for an unknown option."""


class Parser(OptionParser):
    """Parses the arguments of a verb according to its record.

    Args:
        verb: the verb.
        invocation: the invocation. If the command was called by the stock tool's name, help looks like that tool's.
    """

    def __init__(self, verb: Verb, invocation: Invocation) -> None:
        self._as_stock = invocation.as_stock
        self._examples = verb.examples_text(invocation.program, as_stock=invocation.as_stock)
        usage = " ".join(filter(None, ["usage: %prog", verb.name, verb.usage]))
        super().__init__(
            usage=usage, prog=invocation.program, formatter=_Formatter(), description=verb.description or None
        )
        for option in verb.options:
            text = SUPPRESS_HELP if option.hidden or (option.pyros1_only and invocation.as_stock) else option.help
            self.add_option(*option.names, help=text, **option.settings)

    def error(self, msg: str) -> NoReturn:
        """Print the usage and an error, with a suggestion for an unknown option. Exit with code 2."""
        if msg.startswith(_UNKNOWN_OPTION_PREFIX) and not self._as_stock:
            from pyros1.ground.suggest import did_you_mean  # noqa: PLC0415 - only needed after a failure

            visible_options = [option for option in self.option_list if option.help != SUPPRESS_HELP]
            known_names = [name for option in visible_options for name in option._long_opts]
            msg += did_you_mean(msg.removeprefix(_UNKNOWN_OPTION_PREFIX), known_names)
        super().error(msg)

    def format_epilog(self, formatter: HelpFormatter) -> str:
        """Return the examples."""
        return self._examples


class _Formatter(IndentedHelpFormatter):
    """Formats help without reserving space for hidden options, unlike optparse's formatter."""

    def store_option_strings(self, parser: OptionParser) -> None:
        """Measure the widths of the visible options, so that their descriptions are aligned."""
        all_options = parser.option_list
        parser.option_list = [option for option in all_options if option.help != SUPPRESS_HELP]
        try:
            super().store_option_strings(parser)
        finally:
            parser.option_list = all_options
