"""``param delete``: deletes parameters (L83)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.param._arguments import VERBOSE_FLAG, check_arguments
from pyros1.cli.failures import CommandError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb
from pyros1.ground.errors import ParameterNotSetError


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Delete a parameter, or all parameters below a name."""
    check_arguments(args, 1, "parameter name")
    parameter_name = invocation.resolve(args[0])
    try:
        if parameter_name == "/":
            invocation.master.set_param("/", {})
        else:
            invocation.master.delete_param(parameter_name)
    except ParameterNotSetError:
        hint = did_you_mean(parameter_name, invocation.master.get_param_names())
        raise CommandError(f"parameter [{parameter_name}] is not set{hint}") from None
    if options.verbose:
        print(f"deleted parameter [{parameter_name}]")


VERB = Verb(
    "delete",
    "delete parameter",
    VERBOSE_FLAG,
    Argument("parameter", "param"),
    examples=[("/gain", "delete one parameter"), ("/robot1", "delete all parameters below a name")],
    run=run,
)
