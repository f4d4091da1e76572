"""``dynparam load``."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.dynparam._arguments import TIMEOUT, check
from pyros1.cli.commands.dynparam._server import change
from pyros1.cli.failures import CommandError
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import parse_with_negative_numbers
from pyros1.cli.records import Argument, Verb


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Set the parameters of a node from a file."""
    from pyros1.cli.commands.dynparam._files import read_file_text  # noqa: PLC0415 - help does without

    check(args, "a node name", "an input file")
    name, path = args
    try:
        with open(path, encoding="utf-8") as file:
            text = file.read()
    except (OSError, UnicodeDecodeError) as error:
        raise CommandError(f"cannot read [{path}]: {getattr(error, 'strerror', None) or error}") from None
    return change(invocation, name, read_file_text(text, path), options.timeout)


VERB = Verb(
    "load",
    "set parameters of a node from a file",
    TIMEOUT,
    Argument("node", "configurable"),
    Argument("file", "file"),
    examples=[("/camera outdoors.yaml", "a file from `dump`, or plain YAML")],
    parse=parse_with_negative_numbers,
    run=run,
)
