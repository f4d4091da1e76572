"""``pkg help``."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.pkg import COMMAND
from pyros1.cli.commands.pkg import VERB as COMMAND_LINE
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb
from pyros1.cli.running import verb_list

_MORE = """
  Also:
    create NAME [packages]         make a package
    cd|ls|edit|cat [package[/folder]] ...   its folder and files
    --json                         with list, list-names, depends and depends-on: print JSON
"""


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the list of verbs: stock's, and behind them, under our name, those that stock's tool does not have."""
    text = verb_list(COMMAND, invocation.program, as_stock=True)
    if not invocation.as_stock:
        text += _MORE + COMMAND_LINE.examples_text(invocation.program, as_stock=False)
    print(text)


VERB = Verb("help", "help", run=run)
