"""``param list``: prints the names of parameters (L83)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.param._arguments import check_arguments
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON_FLAG, Argument, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.ground.terminal_text import untrusted


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the names of parameters."""
    check_arguments(args, 1)
    names = [*map(untrusted, invocation.master.get_param_names())]
    if args:
        prefix = invocation.resolve(args[0]).rstrip("/") + "/"
        names = [name for name in names if name.startswith(prefix)]
    if options.json:
        print_json(sorted(names))
    else:
        print(*sorted(names), sep="\n")


VERB = Verb(
    "list",
    "list parameter names",
    JSON_FLAG,
    Argument("namespace", "param", optional=True),
    usage="[namespace]",
    examples=[("", "list all names"), ("/robot1", "list the names below /robot1")],
    run=run,
)
