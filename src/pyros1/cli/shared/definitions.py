"""Looks up the definitions of messages and services by name, for ``msg``, ``srv`` and ``msg-proto``."""

from __future__ import annotations

import os
import sys
from functools import cache
from typing import TYPE_CHECKING

from pyros1.cli.failures import EX_USAGE, UsageError, did_you_mean, fail
from pyros1.cli.records import Flag

if TYPE_CHECKING:
    from pyros1.finding.library import Library
    from pyros1.msgs.spec import MessageSpec, ServiceSpec

JSON_LIST_FLAG = Flag("--json", help="print a JSON list", pyros1_only=True)


class DefinitionKind:
    """A kind of definition: messages or services. The attributes are the differences between ``msg`` and ``srv``.

    Attributes:
        extension: the extension of definition files, ``msg`` or ``srv``.
        word: the word for the kind in output, ``message`` or ``service``.
        completion_kinds: the kind of completion candidates for its type names, see `pyros1.cli.complete_values`.
    """

    def __init__(self, extension: str, word: str, completion_kinds: str) -> None:
        self.extension = extension
        self.word = word
        self.completion_kinds = completion_kinds

    def type_names(self, library: Library, package: str) -> list[str]:
        """Return the sorted full names of a package's types."""
        base_names = library.messages(package) if self.extension == "msg" else library.services(package)
        return [f"{package}/{name}" for name in base_names]

    def load_spec(self, library: Library, name: str) -> MessageSpec | ServiceSpec:
        """Return the definition of a type by its full name."""
        return library.message(name) if self.extension == "msg" else library.service(name)


MESSAGE_KIND = DefinitionKind("msg", "message", "message_type")
SERVICE_KIND = DefinitionKind("srv", "service", "service_type")


@cache
def library() -> Library:
    """Return the library of all definitions. The environment is read only once."""
    from pyros1.finding.library import Library  # noqa: PLC0415 - not needed for help

    return Library(os.environ)


def find_full_names(kind: DefinitionKind, type_name: str) -> tuple[list[str], bool]:
    """Return the full names of the types that a name may refer to, and whether the name lacks a package.

    A name with a package is returned unchanged, even if there is no such type.
    """
    if "/" in type_name:
        return [type_name], False
    all_definitions = library()
    return [
        f"{package}/{type_name}"
        for package in all_definitions.packages()
        if f"{package}/{type_name}" in kind.type_names(all_definitions, package)
    ], True


def similar_name_hint(kind: DefinitionKind, type_name: str) -> str:
    """Return a hint with the name of a similar type; empty if there is none."""
    full_names = [full_name for package in library().packages() for full_name in kind.type_names(library(), package)]
    return did_you_mean(
        type_name, full_names if "/" in type_name else {full_name.partition("/")[2] for full_name in full_names}
    )


def parse_type_argument(kind: DefinitionKind, args: list[str]) -> str:
    """Return the name of a type from the arguments or, if there are none, from standard input.

    Raises:
        UsageError: there are too many arguments, or the name is malformed.
        CommandError: no name was given.
    """
    if len(args) > 1:
        raise UsageError(f"you may only specify one {kind.word} type")
    type_name = args[0] if args else read_name_from_stdin()
    if "::" in type_name:
        raise UsageError(
            "rosmsg does not understand C++-style namespaces (i.e. '::').\n"
            "Please refer to msg/srv types as 'package_name/Type'."
        )
    type_name = type_name.removesuffix("." + kind.extension)
    if "." in type_name:
        raise UsageError(f"invalid message type '{type_name}'.\nPlease refer to msg/srv types as 'package_name/Type'.")
    return type_name


def read_name_from_stdin() -> str:
    """Read a name from standard input, for a command without arguments, so that names can be piped to it.

    Raises:
        CommandError: standard input is a terminal or contains no name.
    """
    if sys.stdin.isatty():
        fail("no name was given: add it to the command line, or pipe it to standard input", EX_USAGE)
    for line in sys.stdin:
        if line.strip():
            return line.strip()
    return fail("no name was given", EX_USAGE)
