"""``msg show`` and ``msg info``: print the definition of a type (L86)."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import islice
from typing import TYPE_CHECKING, Any

from pyros1.cli.failures import CommandError, fail
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.shared.definitions import (
    MESSAGE_KIND,
    DefinitionKind,
    find_full_names,
    library,
    parse_type_argument,
    similar_name_hint,
)
from pyros1.cli.shared.options import CHUNK_LIMIT_OPTION
from pyros1.ground.errors import DefinitionError, UnknownTypeError

if TYPE_CHECKING:
    from pyros1.msgs.spec import MessageSpec, ServiceSpec

MAX_LINES = 100_000
"""Maximum number of lines in an expanded definition. Each level of nested types can multiply the number of lines."""


def _print_definition(kind: DefinitionKind, invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the definition of a type, by default with nested types expanded."""
    type_name = parse_type_argument(kind, args)
    if options.bag:
        for text in _definitions_in_bag(options.bag, type_name, options.raw):
            print(text)
        return
    names, lacks_package = find_full_names(kind, type_name)
    if not names:
        fail(f"Could not find msg '{type_name}'{similar_name_hint(kind, type_name)}")
    for full_name in names:
        try:
            spec = kind.load_spec(library(), full_name)
            text = spec.text if options.raw else _expand(spec, library().message)
        except (DefinitionError, UnknownTypeError) as error:
            message = "Unable to load msg" if kind is MESSAGE_KIND else "Unknown srv type"
            fail(f"{message} [{full_name}]: {error}")
        print((f"[{full_name}]:\n" if lacks_package else "") + text)


def make_verbs(kind: DefinitionKind, *examples: tuple[str, str]) -> Sequence[Verb]:
    """Return the two verbs for messages or services."""
    parts = (
        Flag("-r", "--raw", help="show raw message text, including comments"),
        Option("-b", "--bag", metavar="BAGFILE", help=f"show {kind.word} from .bag file"),
        CHUNK_LIMIT_OPTION,
        Argument("type", kind.completion_kinds),
    )
    usage = f"[options] <{kind.word} type>"
    show_verb = Verb(
        "show",
        f"Show {kind.word} description",
        *parts,
        usage=usage,
        examples=examples,
        run=partial(_print_definition, kind),
    )
    info_verb = Verb(
        "info",
        f"Alias for pyros1 {kind.extension} show",
        *parts,
        usage=usage,
        examples=[(examples[0][0], "do the same as show")],
        stock_about=f"Alias for ros{kind.extension} show",
        run=partial(_print_definition, kind),
    )
    return show_verb, info_verb


VERBS = make_verbs(
    MESSAGE_KIND,
    ("geometry_msgs/PoseStamped", "print the fields of a type and of its nested types"),
    ("-r Imu", "print the original text with comments; the package may be left out"),
    ("-b run.bag my_robot/State", "print the definition stored in a bag"),
)


def _expand(spec: MessageSpec | ServiceSpec, resolve: Callable[[str], MessageSpec]) -> str:
    """Return a definition with nested types expanded below each field.

    Args:
        spec: the definition.
        resolve: returns the spec for a full type name.

    Raises:
        DefinitionError: a type contains itself, or the result has more than `MAX_LINES` lines.
    """
    from pyros1.msgs.digest import Digests  # noqa: PLC0415
    from pyros1.msgs.spec import MessageSpec  # noqa: PLC0415

    Digests(resolve).dependencies(spec)  # raises an error if a type contains itself
    parts = (spec,) if isinstance(spec, MessageSpec) else (spec.request, spec.response)
    texts = [
        "".join(line + "\n" for line in islice(_expanded_lines(part, resolve, ""), MAX_LINES + 1)) for part in parts
    ]
    if any(text.count("\n") > MAX_LINES for text in texts):
        raise DefinitionError(
            f"more than {MAX_LINES} lines with all nested types; use --raw to show the text of this type", spec.name
        )
    return "---\n".join(texts)


def _expanded_lines(spec: MessageSpec, resolve: Callable[[str], MessageSpec], indent: str) -> Iterator[str]:
    for constant in spec.constants:
        yield f"{indent}{constant.type} {constant.name}={constant.text}"
    for field in spec.fields:
        yield f"{indent}{field.type} {field.name}"
        if not field.is_builtin:
            yield from _expanded_lines(resolve(field.base), resolve, indent + "  ")


def _definitions_in_bag(path: str, name: str, raw: bool) -> Iterator[str]:
    """Yield each different definition of a type that a bag contains.

    Raises:
        CommandError: the bag does not exist, or lacks the definition of a nested type.
    """
    if not os.path.isfile(path):
        raise CommandError(f"bag file [{path}] does not exist")
    from pyros1 import bag as bags  # noqa: PLC0415 - only needed for bags
    from pyros1.msgs.digest import split_full_text  # noqa: PLC0415
    from pyros1.msgs.spec import parse_message  # noqa: PLC0415

    with bags.open(path) as bag:
        types_by_definition = {bag.definition(connection): connection.type for connection in bag.connections}
    yielded_texts = set()
    for text, type_name in types_by_definition.items():
        parts = split_full_text(type_name, text)
        if name not in parts or (parts[name] in yielded_texts):
            continue
        yielded_texts.add(parts[name])
        if raw:
            yield (text if type_name == name else parts[name]).removesuffix("\n")
        else:
            yield _expand(parse_message(name, parts[name], path), partial(_parse_definition, parts, path))


def _parse_definition(definitions: Mapping[str, str], path: str, type_name: str) -> MessageSpec:
    from pyros1.msgs.spec import parse_message  # noqa: PLC0415

    if type_name not in definitions:
        raise CommandError(f"[{path}] has no definition of {type_name}")
    return parse_message(type_name, definitions[type_name], path)
