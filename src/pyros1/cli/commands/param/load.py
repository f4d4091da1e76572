"""``param load``: sets parameters from a YAML file (L82)."""

from __future__ import annotations

import os
import sys
from typing import Any

from pyros1.cli.commands.param._arguments import VERBOSE_FLAG, check_arguments
from pyros1.cli.commands.param._leaves import set_leaves
from pyros1.cli.failures import CommandError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb
from pyros1.ground.terminal_text import one_line


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Set parameters from a file."""
    check_arguments(args, 2, "file name or - for stdin")
    path = args[0]
    base_namespace = invocation.resolve(args[1]) if len(args) > 1 else invocation.namespace
    if path == "-":
        text, source_name = sys.stdin.read(), "stdin"
        message = "reading parameters from stdin"
    else:
        if not os.path.isfile(path):
            raise CommandError(f"file [{path}] does not exist")
        with open(path, encoding="utf-8") as file:
            text, source_name = file.read(), path
        message = f"reading parameters from [{path}]"
    if options.verbose:
        print(message)
    from pyros1.values import load_all_yaml  # noqa: PLC0415

    parsed_documents = []
    for document in load_all_yaml(text, source_name):
        if document is None:
            continue
        namespace = base_namespace
        if isinstance(document, dict) and "_ns" in document:
            namespace = _resolve_in(base_namespace, str(document.pop("_ns")))
            if options.verbose:
                print(f"reading parameters into namespace [{namespace}]")
        elif not isinstance(document, dict) and base_namespace == "/":
            raise CommandError(f"{source_name}: expected a dictionary of parameters, not {one_line(document, 60)!r}")
        parsed_documents.append((namespace, document))
    for namespace, document in parsed_documents:
        set_leaves(invocation, namespace, document, "{}={}" if options.verbose else "")


VERB = Verb(
    "load",
    "load parameters from file",
    VERBOSE_FLAG,
    Argument("file", "file"),
    Argument("namespace", "param", optional=True),
    examples=[("robot.yaml /robot1", "load a file into a namespace")],
    run=run,
)


def _resolve_in(base_namespace: str, name: str) -> str:
    from pyros1.ground.names import canonicalize_name, ns_join  # noqa: PLC0415

    return canonicalize_name(ns_join(base_namespace, name))
