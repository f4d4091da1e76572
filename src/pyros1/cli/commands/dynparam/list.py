"""``dynparam list``."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.dynparam._server import known
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.ground.shown import one_line


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print nodes that can be configured."""
    names = known(invocation)
    if options.json:
        print_json(names)
    elif names:
        print(*map(one_line, names), sep="\n")


VERB = Verb(
    "list",
    "list nodes that can be configured",
    JSON,
    usage="",
    examples=[("", "the nodes whose parameters can be changed while they run")],
    run=run,
)
