"""``stack help``."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.stack import COMMAND
from pyros1.cli.invocation import Invocation
from pyros1.cli.running import verb_list
from pyros1.cli.shared.rospack.tool import pack_verb


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the list of verbs. It is stock's list under either name."""
    print(verb_list(COMMAND, invocation.program, as_stock=True))


VERB = pack_verb("help", "help", run=run, examples=[("", "the list of verbs")])
