"""``dynparam set``."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.dynparam._arguments import TIMEOUT, check
from pyros1.cli.commands.dynparam._server import change
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import parse_with_negative_numbers
from pyros1.cli.records import Argument, Verb

_FORM = "either a node name, parameter name and parameter value, or a node name and a YAML dictionary"


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Set one parameter of a node, or those of a YAML dictionary."""
    check(args, _FORM, _FORM, most=3)
    name, *rest = args
    if len(rest) == 1:
        from pyros1.values import load_yaml  # noqa: PLC0415 - help does without

        values = load_yaml(rest[0])
        if not isinstance(values, dict):
            raise UsageError(f"invalid arguments. Please specify {_FORM}")
    else:
        values = {rest[0]: rest[1]}
    return change(invocation, name, values, options.timeout)


VERB = Verb(
    "set",
    "set parameters of a node",
    TIMEOUT,
    Argument("node", "configurable"),
    Argument("parameter"),
    Argument("value", optional=True),
    usage="[options] node (parameter value | values)",
    examples=[
        ("/camera exposure 0.02", "one parameter; choices can be given by name"),
        ('/camera "{exposure: 0.02, auto: false}"', "several at once"),
    ],
    parse=parse_with_negative_numbers,
    run=run,
)
