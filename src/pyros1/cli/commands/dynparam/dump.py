"""``dynparam dump``."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.dynparam._arguments import TIMEOUT, check
from pyros1.cli.commands.dynparam._server import Server, refuse
from pyros1.cli.failures import CommandError
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import parse_with_negative_numbers
from pyros1.cli.records import Argument, Verb
from pyros1.ground.whole_file import write_whole


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Write a node's configuration to a file."""
    from pyros1.cli.commands.dynparam._files import file_text  # noqa: PLC0415 - help does without

    check(args, "a node name", "an output file")
    name, path = args
    code = 0
    with invocation.open_node() as node:
        values = Server(invocation, node, name, options.timeout).configuration()
        if values is None:
            code = refuse(invocation, f"couldn't get parameters from node {name}")
        else:
            _write(path, file_text(values))
    return code


VERB = Verb(
    "dump",
    "write a node's configuration to a file",
    TIMEOUT,
    Argument("node", "configurable"),
    Argument("file", "file"),
    examples=[("/camera outdoors.yaml", "write it to a file")],
    parse=parse_with_negative_numbers,
    run=run,
)


def _write(path: str, text: str) -> None:
    try:
        write_whole(path, text)
    except OSError as error:
        raise CommandError(f"cannot write [{path}]: {error.strerror}") from None
