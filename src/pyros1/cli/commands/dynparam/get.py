"""``dynparam list``, ``get`` and ``dump``: print and save the configurations of nodes."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.dynparam._arguments import TIMEOUT_OPTION, check_arguments
from pyros1.cli.commands.dynparam._server import ReconfigureServer, configurable_nodes, report_failure
from pyros1.cli.failures import CommandError
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import parse_with_negative_numbers
from pyros1.cli.records import JSON_FLAG, Argument, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.ground.atomic_file import write_atomically
from pyros1.ground.terminal_text import one_line


def _print_nodes(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print nodes that can be configured."""
    names = configurable_nodes(invocation)
    if options.json:
        print_json(names)
    elif names:
        print(*map(one_line, names), sep="\n")


def _print_configuration(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print a node's configuration as a Python dictionary, which is also YAML."""
    check_arguments(args, "a node name")
    values = None
    with invocation.open_node() as node:  # Ctrl-C stops waiting and leaves this block silently
        values = ReconfigureServer(invocation, node, args[0], options.timeout).configuration()
    if values is None:
        return
    if options.json:
        print_json(values)
    else:
        print(values)


def _dump_configuration(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Write a node's configuration to a file. Return the exit code."""
    from pyros1.cli.commands.dynparam._files import file_text  # noqa: PLC0415 - not needed for help

    check_arguments(args, "a node name", "an output file")
    node_name, path = args
    code = 0
    with invocation.open_node() as node:
        values = ReconfigureServer(invocation, node, node_name, options.timeout).configuration()
        if values is None:
            code = report_failure(invocation, f"couldn't get parameters from node {node_name}")
        else:
            _write_file(path, file_text(values))
    return code


def _write_file(path: str, text: str) -> None:
    try:
        write_atomically(path, text)
    except OSError as error:
        raise CommandError(f"cannot write [{path}]: {error.strerror}") from None


VERBS = [
    Verb(
        "list",
        "list nodes that can be configured",
        JSON_FLAG,
        usage="",
        examples=[("", "list the nodes whose parameters can be changed while they are running")],
        run=_print_nodes,
    ),
    Verb(
        "get",
        "print a node's configuration",
        TIMEOUT_OPTION,
        JSON_FLAG,
        Argument("node", "reconfigurable_node"),
        examples=[("/camera", "print all parameters of a node"), ("--json /camera", "print JSON for programs")],
        parse=parse_with_negative_numbers,
        run=_print_configuration,
    ),
    Verb(
        "dump",
        "write a node's configuration to a file",
        TIMEOUT_OPTION,
        Argument("node", "reconfigurable_node"),
        Argument("file", "file"),
        examples=[("/camera outdoors.yaml", "save a node's configuration")],
        parse=parse_with_negative_numbers,
        run=_dump_configuration,
    ),
]
