"""``param dump``: writes parameters to a YAML file (L82)."""

from __future__ import annotations

import sys
from typing import Any

from pyros1.cli.commands.param._arguments import VERBOSE_FLAG, check_arguments
from pyros1.cli.commands.param._leaves import leaves
from pyros1.cli.failures import CommandError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb
from pyros1.ground.atomic_file import write_atomically
from pyros1.ground.errors import ParameterNotSetError


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Write parameters as YAML to a file or stdout."""
    check_arguments(args, 2)
    path = args[0] if args else None
    namespace = args[1] if len(args) > 1 else ""
    name = invocation.resolve(namespace)
    if options.verbose:
        print(f"dumping namespace [{namespace}] to file [{path}]")
    try:
        tree = invocation.master.get_param(name)
    except ParameterNotSetError as error:
        raise CommandError(str(error)) from None
    if options.verbose:
        for leaf, value in leaves(name, tree):
            if value != {}:
                print(f"{leaf}={value}")
    from pyros1.values import dump_yaml  # noqa: PLC0415

    text = dump_yaml(tree)
    if path is None:
        sys.stdout.write(text)
        return
    write_atomically(path, text)


VERB = Verb(
    "dump",
    "dump parameters to file",
    VERBOSE_FLAG,
    Argument("file", "file"),
    Argument("namespace", "param", optional=True),
    usage="[options] file [namespace]",
    examples=[("all.yaml", "write all parameters to a file")],
    run=run,
)
