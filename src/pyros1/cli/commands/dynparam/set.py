"""``dynparam set``, ``load`` and ``set_from_parameters``: change the configuration of a node."""

from __future__ import annotations

import sys
from typing import Any

from pyros1.cli.commands.dynparam._arguments import TIMEOUT_OPTION, check_arguments
from pyros1.cli.commands.dynparam._server import change_with_new_node, failure_code, set_parameters
from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import parse_with_negative_numbers
from pyros1.cli.records import Argument, Verb
from pyros1.ground.errors import ParameterNotSetError

_EXPECTED_ARGUMENTS = "either a node name, parameter name and parameter value, or a node name and a YAML dictionary"


def _set_from_arguments(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Set one parameter of a node, or all parameters in a YAML dictionary. Return the exit code."""
    check_arguments(args, _EXPECTED_ARGUMENTS, _EXPECTED_ARGUMENTS, max_arguments=3)
    node_name, *value_args = args
    if len(value_args) == 1:
        from pyros1.values import load_yaml  # noqa: PLC0415 - not needed for help

        values = load_yaml(value_args[0])
        if not isinstance(values, dict):
            raise UsageError(f"invalid arguments. Please specify {_EXPECTED_ARGUMENTS}")
    else:
        values = {value_args[0]: value_args[1]}
    return change_with_new_node(invocation, node_name, values, options.timeout)


def _set_from_file(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Set the parameters of a node from a file. Return the exit code."""
    from pyros1.cli.commands.dynparam._files import read_file_text  # noqa: PLC0415 - not needed for help

    check_arguments(args, "a node name", "an input file")
    node_name, path = args
    try:
        with open(path, encoding="utf-8") as file:
            text = file.read()
    except (OSError, UnicodeDecodeError) as error:
        raise CommandError(f"cannot read [{path}]: {getattr(error, 'strerror', None) or error}") from None
    return change_with_new_node(invocation, node_name, read_file_text(text, path), options.timeout)


def _set_from_parameters(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Set parameters of a node to the values of this command's private parameters. Return the exit code."""
    check_arguments(args, "a node name")
    code = 0
    with invocation.open_node() as node:
        try:
            values = node.params["~"]
        except ParameterNotSetError:
            values = None
        if not isinstance(values, dict) or not values:
            print("error updating parameters: no parameters found on parameter server", file=sys.stderr)
            code = failure_code(invocation)
        else:
            code = set_parameters(invocation, node, args[0], values, options.timeout)
    return code


VERBS = [
    Verb(
        "set",
        "set parameters of a node",
        TIMEOUT_OPTION,
        Argument("node", "reconfigurable_node"),
        Argument("parameter"),
        Argument("value", optional=True),
        usage="[options] node (parameter value | values)",
        examples=[
            ("/camera exposure 0.02", "set one parameter; for an enumeration, the value can be a name"),
            ('/camera "{exposure: 0.02, auto: false}"', "set several parameters at once"),
        ],
        parse=parse_with_negative_numbers,
        run=_set_from_arguments,
    ),
    Verb(
        "load",
        "set parameters of a node from a file",
        TIMEOUT_OPTION,
        Argument("node", "reconfigurable_node"),
        Argument("file", "file"),
        examples=[("/camera outdoors.yaml", "load a file that `dynparam dump` wrote, or plain YAML")],
        parse=parse_with_negative_numbers,
        run=_set_from_file,
    ),
    Verb(
        "set_from_parameters",
        "set parameters of a node to the values of this command's private parameters, such as _exposure:=0.02",
        TIMEOUT_OPTION,
        Argument("node", "reconfigurable_node"),
        usage="[options] node [_parameter:=value ...]",
        examples=[
            ("/camera _exposure:=0.02", "set the parameter exposure; launch files can give the value as <param>")
        ],
        parse=parse_with_negative_numbers,
        run=_set_from_parameters,
    ),
]
