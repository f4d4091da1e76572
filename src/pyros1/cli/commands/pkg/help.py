"""``pkg help``: prints the list of verbs."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.pkg import COMMAND
from pyros1.cli.commands.pkg._rospack import make_verb
from pyros1.cli.invocation import Invocation
from pyros1.cli.running import verb_list

_ADDITIONAL_VERBS = """
  Also:
    create NAME [packages]         create a package
    cd|ls|edit|cat [package[/folder]] ...   work with the folder and files of a package
    --json                         with list, list-names, depends and depends-on: print JSON
"""


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the list of rospack's verbs and, for ``pyros1``, also the verbs that rospack lacks."""
    text = verb_list(COMMAND, invocation.program, as_stock=True)
    if not invocation.as_stock:
        text += _ADDITIONAL_VERBS + VERB.examples_text(invocation.program, as_stock=False)
    print(text)


VERB = make_verb(
    "help",
    "help",
    run=run,
    examples=[
        ("pyros1 pkg create my_robot std_msgs", "create a package with nodes, a message and a launch file"),
        ("pyros1 pkg find my_robot", "print the folder of a package"),
        ("pyros1 pkg depends-why --target=std_msgs roscpp", "print why one package needs another"),
    ],
)
