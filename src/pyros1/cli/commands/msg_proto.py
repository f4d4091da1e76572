"""``pyros1 msg-proto msg|srv TYPE``: rosmsg-proto, a template to fill in for ``topic pub`` and ``service call`` (L89).

Shells use it for completion. Short collections are written on several lines, long ones and all that follow them in
brackets.
"""

from __future__ import annotations

import sys
from collections.abc import Collection
from typing import Any

from pyros1.cli.failures import EX_USAGE
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Command, Flag, Option, Verb
from pyros1.ground.errors import Error
from pyros1.msgs import Message, load_message, load_service
from pyros1.msgs.base import nested_classes
from pyros1.values.writing import dump

LONG = 4
"""Largest number of entries of a short collection."""


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Print a template."""

    def say(text: str) -> None:
        if not options.silent:
            print(text, file=sys.stderr)

    if len(args) < 2:
        say("Insufficient arguments: give msg or srv, and a type")
        return EX_USAGE
    if args[0] not in ("msg", "srv"):
        say(f"Invalid type: {args[0]!r} is neither msg nor srv")
        return EX_USAGE
    excluded = (options.exclude_slots or "").split(",")
    try:
        text = template(args[0], args[1], options.flow_style, empty_arrays=options.empty_arrays, excluded=excluded)
    except Error as error:
        say(f"Unknown {'message' if args[0] == 'msg' else 'service'} class: {error}")
        return 0 if options.silent else 1  # completion must not disturb
    text = "\n".join(options.prefix + line for line in text.split("\n"))
    print(text if options.no_hyphens else f'"{text}"')
    return 0


COMMAND = Command(
    "msg-proto",
    "print a message or service request to fill in",
    Verb(
        "",
        "",
        Option(
            "-f",
            "--flow_style",
            type="int",
            help="if 1 always use brackets, if 0 never use brackets. Default is a heuristic mix.",
        ),
        Flag("-e", "--empty-arrays", help="if true flexible size arrays are not filled with default instance"),
        Flag("-s", "--silent", help="suppress all error messages"),
        Option(
            "-p",
            "--prefix",
            metavar="prefix",
            default="",
            help="prefix to print before each line, can be used for indent",
        ),
        Flag("-H", "--no-hyphens", help="if true output has no outer hyphens"),
        Option("-x", "--exclude-slots", help="comma separated list of slot names not to print"),
        Argument("msg|srv", "definition_kind"),
        Argument("TYPE", "definition"),
        usage="msg|srv [options] TYPE",
        description="Prints a template of a message or service request to fill in. Shells use it for completion.",
        examples=[
            ("msg geometry_msgs/Twist", "a message, in quotes"),
            ("srv -H std_srvs/SetBool", "a service request, without quotes"),
        ],
        run=run,
    ),
    group="develop",
    stock="rosmsg-proto",
)


def template(
    mode: str,
    name: str,
    flow_style: int | None = None,
    *,
    empty_arrays: bool = False,
    excluded: Collection[str] = (),
) -> str:
    """Return a template of a message or a service request as YAML.

    Args:
        mode: ``msg`` or ``srv``.
        name: name of the type.
        flow_style: 1 puts everything in brackets, 0 nothing. None uses brackets for the innermost collections,
            starting at the first field with a long collection, or for all fields if there are many or one is a long
            array.
        empty_arrays: arrays of variable length have no element.
        excluded: fields to leave out.

    Raises:
        Error: the type is unknown.
    """
    fields = _prototype(_load(mode, name)(), empty_arrays)
    return _render({field: value for field, value in fields.items() if field not in excluded}, flow_style)


def _load(mode: str, name: str) -> Any:
    if "/" not in name:
        from pyros1.cli.shared.definitions import MESSAGES, SERVICES, find  # noqa: PLC0415 - shells ask with full names

        names, _ = find(MESSAGES if mode == "msg" else SERVICES, name)
        name = names[0] if names else name
    return load_message(name) if mode == "msg" else load_service(name)._request_class


def _prototype(message: Message, empty_arrays: bool) -> dict[str, Any]:
    """Return the message as dictionaries, with one element in each array of variable length."""
    result: dict[str, Any] = {}
    for name, slot_type in zip(message.__slots__, message._slot_types, strict=True):
        result[name] = _field(getattr(message, name), slot_type, nested_classes(type(message)), empty_arrays)
    return result


def _field(value: Any, slot_type: str, classes: Any, empty_arrays: bool) -> Any:
    base, bracket, length = slot_type.partition("[")
    if bracket:
        if base in ("uint8", "char"):
            return bytes(value)
        if length == "]" and not empty_arrays:
            value = [_element(base, classes)]
        return [_field(item, base, classes, empty_arrays) for item in value]
    if isinstance(value, Message):
        return _prototype(value, empty_arrays)
    if base in ("time", "duration"):
        return {"secs": value.secs, "nsecs": value.nsecs}
    return value


def _element(base: str, classes: Any) -> Any:
    if base in classes:
        return classes[base]()
    if base in ("time", "duration"):
        from pyros1.ground.timing import Duration, Time  # noqa: PLC0415

        return Time() if base == "time" else Duration()
    return "" if base == "string" else 0


# Layout ---------------------------------------------------------------------------------------------------------------


def _render(value: dict[str, Any], flow_style: int | None) -> str:
    brackets: set[int] = set()
    if flow_style == 1:
        brackets.add(id(value))
    elif flow_style != 0:
        _choose(value, brackets, False)
    return dump(value, inline=lambda part: id(part) in brackets, ordered=True).rstrip("\n")


def _parts(value: Any) -> list[Any]:
    return list(value.values()) if isinstance(value, dict) else value if isinstance(value, list) else []


def _choose(value: Any, brackets: set[int], found: bool) -> bool:
    """Choose which collections get brackets. Return whether a long collection was found."""
    parts = _parts(value)
    if found or len(parts) > LONG or any(isinstance(part, list) and len(part) > LONG for part in parts):
        _add_leaves(value, brackets)
        return True
    for part in parts:
        found = _choose(part, brackets, found)
    return found


def _add_leaves(value: Any, brackets: set[int]) -> None:
    parts = _parts(value)
    if isinstance(value, (dict, list)) and not any(isinstance(part, (dict, list)) for part in parts):
        brackets.add(id(value))
    for part in parts:
        _add_leaves(part, brackets)
