"""``msg md5``: prints the checksum of a type (L88)."""

from __future__ import annotations

import sys
from functools import partial
from typing import Any

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb
from pyros1.cli.shared.definitions import (
    MESSAGE_KIND,
    DefinitionKind,
    find_full_names,
    library,
    parse_type_argument,
    similar_name_hint,
)
from pyros1.ground.errors import UnknownTypeError


def _print_checksum(kind: DefinitionKind, invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print a type's checksum. For an unknown type, print an error to stderr and return 0, as in stock ROS."""
    type_name = parse_type_argument(kind, args)
    names, lacks_package = find_full_names(kind, type_name)
    if lacks_package and not names:
        print(f"No {kind.word}s matching the name [{type_name}]", file=sys.stderr)
    for full_name in names:
        try:
            checksum = library().digests.md5(kind.load_spec(library(), full_name))
        except UnknownTypeError:
            print(f"Cannot locate [{full_name}]{similar_name_hint(kind, full_name)}", file=sys.stderr)
            continue
        print(f"[{full_name}]: {checksum}" if lacks_package else checksum)


def make_verb(kind: DefinitionKind, *examples: tuple[str, str]) -> Verb:
    """Return the verb for messages or services.

    Args:
        kind: messages or services.
        examples: the examples, see `Verb`.
    """
    return Verb(
        "md5",
        f"Display {kind.word} md5sum",
        Argument("type", kind.completion_kinds),
        usage=f"<{kind.word} type>",
        examples=examples,
        run=partial(_print_checksum, kind),
    )


VERB = make_verb(
    MESSAGE_KIND, ("std_msgs/String", "print the checksum, which must be the same for publisher and subscriber")
)
