"""The option parser that a verb's record makes, and the layout of its help."""

from __future__ import annotations

from collections.abc import Sequence
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
        self._examples = "" if stock else examples_text(f"{invocation.program} {verb.name}".rstrip(), verb.examples)
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


def examples_text(called: str, examples: Sequence[tuple[str, str]]) -> str:
    """Return a block of examples, to be put behind an empty line; empty if there are none.

    Args:
        called: how the verb was called: ``pyros1 topic echo``.
        examples: as `Verb` has them.
    """
    rows = [(line if line.startswith("pyros1 ") else f"{called} {line}".rstrip(), about) for line, about in examples]
    width = max((len(line) for line, _ in rows), default=0)
    return "\nExamples:\n" * bool(rows) + "".join(f"  {line:{width}}  {about}".rstrip() + "\n" for line, about in rows)


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
