"""``param set``: sets a parameter (L80)."""

from __future__ import annotations

import os
from typing import Any

from pyros1.cli.commands.param._arguments import VERBOSE_FLAG, check_arguments
from pyros1.cli.commands.param._leaves import set_leaves
from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import parse_with_negative_numbers
from pyros1.cli.records import Argument, Option, Verb


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Set a parameter to a value or to the contents of a file."""
    check_arguments(args, 2, "parameter name")
    parameter_name = invocation.resolve(args[0])
    message_format = "set parameter [{}] to [{}]" if options.verbose else ""
    if options.text_file and options.bin_file:
        raise UsageError("you may only specify one of --textfile or --binfile")
    if options.text_file:
        if not os.path.isfile(options.text_file):
            raise UsageError(f"file '{options.text_file}' does not exist")
        with open(options.text_file, encoding="utf-8") as text_file:
            set_leaves(invocation, parameter_name, text_file.read(), message_format)
        return
    if options.bin_file:
        try:
            with open(options.bin_file, "rb") as binary_file:
                binary_data = binary_file.read()
        except OSError as error:
            raise CommandError(f"cannot read [{options.bin_file}]: {error.strerror}") from None
        invocation.master.set_param(parameter_name, binary_data)
        if options.verbose:
            print(f"set parameter [{parameter_name}] to [{binary_data.decode('utf-8', 'replace')}]")
        return
    if len(args) < 2 or args[1] in ("-", "--"):
        raise UsageError("invalid arguments. Please specify a parameter value")
    from pyros1.values import load_yaml  # noqa: PLC0415

    set_leaves(invocation, parameter_name, "" if args[1] == "" else load_yaml(args[1]), message_format)


VERB = Verb(
    "set",
    "set parameter",
    Option(
        "-t",
        "--textfile",
        dest="text_file",
        metavar="TEXT_FILE",
        help="set parameters to contents of text file",
    ),
    Option(
        "-b",
        "--binfile",
        dest="bin_file",
        metavar="BINARY_FILE",
        help="set parameters to contents of binary file",
    ),
    VERBOSE_FLAG,
    Argument("parameter", "param"),
    Argument("value"),
    examples=[
        ("/gain 2.5", "set a number"),
        ("/name \"'42'\"", "set a string, quoted for YAML"),
        ("/limits '{low: 0, high: deg(90)}'", "set several parameters"),
    ],
    parse=parse_with_negative_numbers,
    run=run,
)
