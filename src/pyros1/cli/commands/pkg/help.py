"""``pkg help``."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.pkg import COMMAND
from pyros1.cli.commands.pkg._rospack import pack_verb
from pyros1.cli.invocation import Invocation
from pyros1.cli.running import verb_list

_MORE = """
  Also:
    create NAME [packages]         create a package
    cd|ls|edit|cat [package[/folder]] ...   its folder and files
    --json                         with list, list-names, depends and depends-on: print JSON
"""


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the list of verbs: stock's verbs, and after them, under our name, those that stock lacks."""
    text = verb_list(COMMAND, invocation.program, as_stock=True)
    if not invocation.as_stock:
        text += _MORE + VERB.examples_text(invocation.program, as_stock=False)
    print(text)


VERB = pack_verb(
    "help",
    "help",
    run=run,
    examples=[
        ("pyros1 pkg create my_robot std_msgs", "create a package with nodes, a message and a launch file"),
        ("pyros1 pkg find my_robot", "where it is"),
        ("pyros1 pkg depends-why --target=std_msgs roscpp", "why one package needs another"),
    ],
)
