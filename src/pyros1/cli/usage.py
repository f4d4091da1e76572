"""Usage texts that end with examples."""

from __future__ import annotations

from optparse import SUPPRESS_HELP, HelpFormatter, IndentedHelpFormatter, OptionParser

from pyros1.cli.common import program_name


class Parser(OptionParser):
    """An option parser whose help ends with examples, as they are written.

    Args:
        stock: the stock tool's name, for example ``roslaunch``.
        usage: the first lines, with ``%prog`` for the program.
        examples: command lines with ``%prog``, each with what it does.
    """

    def __init__(self, stock: str, usage: str, examples: dict[str, str]) -> None:
        self._examples = examples
        super().__init__(usage=f"usage: {usage}", prog=program_name(stock))

    def format_epilog(self, formatter: HelpFormatter) -> str:
        """Return the examples."""
        return examples_text(self.get_prog_name(), self._examples)


class HidingFormatter(IndentedHelpFormatter):
    """Lays help out as if hidden options were not there; optparse's own leaves room for them."""

    def store_option_strings(self, parser: OptionParser) -> None:
        """Measure the options that are shown."""
        everything = parser.option_list
        parser.option_list = [option for option in everything if option.help != SUPPRESS_HELP]
        try:
            super().store_option_strings(parser)
        finally:
            parser.option_list = everything


def examples_text(program: str, examples: dict[str, str]) -> str:
    """Return a block of examples, to be put behind an empty line.

    Args:
        program: how the program was called.
        examples: command lines with ``%prog``, each with what it does.
    """
    rows = {line.replace("%prog", program): about for line, about in examples.items()}
    width = max(map(len, rows))
    return "\nExamples:\n" + "".join(f"  {line:{width}}  {about}\n" for line, about in rows.items())
