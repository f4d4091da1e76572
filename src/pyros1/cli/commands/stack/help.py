"""``stack help``."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.stack import COMMAND
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb
from pyros1.cli.running import verb_list


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the list of verbs, which is that of stock's tool under either name."""
    print(verb_list(COMMAND, invocation.program, as_stock=True))


VERB = Verb("help", "help", run=run)
