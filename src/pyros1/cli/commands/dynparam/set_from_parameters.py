"""``dynparam set_from_parameters``."""

from __future__ import annotations

import sys
from typing import Any

from pyros1.cli.commands.dynparam._arguments import TIMEOUT, check
from pyros1.cli.commands.dynparam._server import apply, failed
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import parse_with_negative_numbers
from pyros1.cli.records import Argument, Verb
from pyros1.ground.errors import ParameterNotSetError


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Set the parameters of a node to the private parameters of this command's node."""
    check(args, "a node name")
    code = 0
    with invocation.open_node() as node:
        try:
            values = node.params["~"]
        except ParameterNotSetError:
            values = None
        if not isinstance(values, dict) or not values:
            print("error updating parameters: no parameters found on parameter server", file=sys.stderr)
            code = failed(invocation)
        else:
            code = apply(invocation, node, args[0], values, options.timeout)
    return code


VERB = Verb(
    "set_from_parameters",
    "set parameters of a node to the private parameters of this command",
    TIMEOUT,
    Argument("node", "configurable"),
    usage="[options] node [_parameter:=value ...]",
    examples=[("/camera _exposure:=0.02", "from private parameters, for launch files")],
    parse=parse_with_negative_numbers,
    run=run,
)
