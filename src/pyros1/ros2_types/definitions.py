"""Parses the .msg, .srv and .action texts of ROS 2
(https://docs.ros.org/en/jazzy/Concepts/Basic/About-Interfaces.html).

Each line is either ``type name``, with an optional default value, or a constant, ``type NAME=value``; ``#`` starts a
comment. Defaults and constants are skipped: they do not matter for encoding and hashing. No I/O.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

from pyros1.ground.errors import DefinitionError
from pyros1.ros2_types.model import STRINGS, STRUCT_CODES, Field, FieldType, Length, MessageType
from pyros1.ros2_types.nesting import all_types

MAX_TEXT_LENGTH = 1 << 20
"""Maximum length in characters of a text that defines a type and all types that it uses."""

MAX_FIELDS = 10_000
"""Maximum total number of fields of all types that a text defines."""

PARTS = {"msg": ("",), "srv": ("_Request", "_Response"), "action": ("_Goal", "_Result", "_Feedback")}
"""Folder of a type -> the suffixes of the names of its parts, which are separated by ``---``."""

_SINGLE_PARTS = (*PARTS["srv"], *PARTS["action"], "_FeedbackMessage", "_Event")

# Unlike rosidl, allow capitals in package and field names, and lower-case first letters of types, as ROS 1 does: other
# tools than rosidl have converted such packages to ROS 2.
_NAME = r"[A-Za-z](?:_?[A-Za-z0-9])*"
_NAME_PATTERN = re.compile(rf"{_NAME}\Z")
_TYPE_NAME_PATTERN = re.compile(rf"({_NAME})/(?:(msg|srv|action)/)?({_NAME})\Z")
_FIELD_TYPE_PATTERN = re.compile(
    r"(?P<base>[A-Za-z0-9_/]+)(?:<=(?P<bound>[0-9]{1,10}))?(?P<array>\[(?P<bounded><=)?(?P<size>[0-9]{1,10})?\])?\Z"
)
_FIELD_PATTERN = re.compile(r"(?P<type>\S+)\s+(?P<name>[^\s=]+)(?P<constant>\s*=)?")
_SEPARATOR_PATTERN = re.compile(r"={3,}\Z")
MAX_SIZE = (1 << 32) - 1
"""Maximum size of arrays and strings: CDR and XCDR count in 32 bits."""


class _Text(NamedTuple):
    """The definition of one type: its name and its lines with their numbers, stripped."""

    name: str
    title_line: int
    lines: list[tuple[int, str]]


def full_type_name(name: str, where: str | None = None, line: int | None = None) -> str:
    """Return a type's full name, for example ``std_msgs/msg/String``, also for ``std_msgs/String``.

    Args:
        name: the name.
        where: name of the text that contains it, for the error message.
        line: its line there, from 1.

    Raises:
        DefinitionError: the name is not legal.
    """
    match = _TYPE_NAME_PATTERN.match(name)
    if match is None:
        raise DefinitionError(f"[{name}] is not a type name of the form package/msg/Type", where, line)
    package, folder, short = match.groups()
    return f"{package}/{folder or 'msg'}/{short}"


def parse_types(name: str, text: str) -> dict[str, MessageType]:
    """Parse the definition of a type.

    Args:
        name: full name of the type: ``package/msg/Type``, ``package/srv/Type`` or ``package/action/Type``;
            ``package/Type`` is a message.
        text: its definition. The definitions of types that it uses may follow, each after a line of ``=`` and a line
            ``MSG: package/msg/Type``, as in ROS 2 bags and MCAP files.

    Returns:
        Full name -> type, for the types in the text. A service consists of the types ``..._Request`` and
        ``..._Response``, an action of ``..._Goal``, ``..._Result`` and ``..._Feedback``.

    Raises:
        DefinitionError: the text is invalid or too long, or a type contains itself; the error names the line.
    """
    name = full_type_name(name)
    if len(text) > MAX_TEXT_LENGTH:
        raise DefinitionError(f"the definition has {len(text)} characters; the limit is {MAX_TEXT_LENGTH}", name)
    types: dict[str, MessageType] = {}
    count = 0
    for part in (part for whole in _split_types(name, text) for part in _split_parts(name, whole)):
        if part.name in types:
            continue  # some writers append a type twice if two types use it
        fields: dict[str, Field] = {}
        for line, content in part.lines:
            field = _parse_line(content, part.name, name, line)
            if field is None:
                continue
            if field.name in fields:
                raise DefinitionError(f"field [{field.name}] occurs twice", name, line)
            fields[field.name] = field
            count += 1
            if count > MAX_FIELDS:
                raise DefinitionError(f"more than {MAX_FIELDS} fields", name, line)
        types[part.name] = MessageType(part.name, tuple(fields.values()))
    all_types(types, types, may_miss=True)
    return types


def _split_types(name: str, text: str) -> Iterator[_Text]:
    """Yield the definitions in a text."""
    current = _Text(name, 1, [])
    lines = enumerate(text.split("\n"), 1)
    for line, raw in lines:
        content = raw.strip()
        if not _SEPARATOR_PATTERN.match(content):
            if content and not content.startswith("#"):
                current.lines.append((line, content))
            continue
        title = next(lines, (line, ""))[1].strip()
        keyword, colon, title_name = title.partition(":")
        if keyword not in ("MSG", "SRV", "ACTION") or not colon:
            reason = "IDL is not supported" if keyword == "IDL" else "no 'MSG: type' line after a separator"
            raise DefinitionError(reason, name, line + 1)
        next_name = full_type_name(title_name.strip(), name, line + 1)
        # Some writers put a title before the first type, too.
        if current.lines or current.name != name or current.title_line > 1 or next_name != name:
            yield current
        current = _Text(next_name, line + 1, [])
    yield current


def _split_parts(root: str, whole: _Text) -> Iterator[_Text]:
    """Yield the parts of a service or action; a message is a single part."""
    endings = PARTS[whole.name.split("/")[1]]
    name = whole.name
    if name.endswith(_SINGLE_PARTS):
        endings = ("",)  # some writers store each part like a message
    parts: list[_Text] = [_Text(name, whole.title_line, [])]
    for line, content in whole.lines:
        if content == "---":
            if len(parts) == len(endings):
                raise DefinitionError(f"a line '---' too many in [{name}]", root, line)
            parts.append(_Text(name, line, []))
        else:
            parts[-1].lines.append((line, content))
    if len(parts) < len(endings):
        missing = len(endings) - len(parts)
        raise DefinitionError(f"[{name}] lacks {missing} of its lines '---'", root, whole.title_line)
    for part, ending in zip(parts, endings, strict=True):
        yield _Text(name + ending, part.title_line, part.lines)


def _parse_line(content: str, owner: str, where: str, line: int) -> Field | None:
    """Return the field in a line; None if it is a constant."""
    # A '#' is only looked for up to the name; after that, there is only a default or a constant's value to skip.
    match = _FIELD_PATTERN.match(content)
    if match is None or "#" in match["type"]:
        raise DefinitionError(f"[{content:.200}] is not of the form 'type name'", where, line)
    name = match["name"].partition("#")[0]
    if not _NAME_PATTERN.match(name):
        raise DefinitionError(f"[{name:.200}] is not a legal name", where, line)
    try:
        field_type = _parse_field_type(match["type"], owner.partition("/")[0])
    except ValueError as error:
        raise DefinitionError(str(error), where, line) from None
    is_constant = match["constant"] is not None and name == match["name"]
    if is_constant and (field_type.is_nested or field_type.length is not Length.SINGLE):
        raise DefinitionError(f"[{match['type']:.200}] is not a legal constant type", where, line)
    return None if is_constant else Field(name, field_type)


def _parse_field_type(text: str, package: str) -> FieldType:
    """Return a field's type; raises ValueError.

    Args:
        text: the type as written.
        package: package of types written without one.
    """
    match = _FIELD_TYPE_PATTERN.match(text)
    if match is None:
        raise ValueError(f"[{text:.200}] is not a legal field type")
    base = match["base"]
    if base == "char":
        base = "uint8"  # as in rosidl
    if base not in STRUCT_CODES and base not in STRINGS:
        qualified = _TYPE_NAME_PATTERN.match(base if "/" in base else f"{package}/{base}")
        if qualified is None:
            raise ValueError(f"[{base:.200}] is not a legal type name")
        base = f"{qualified[1]}/{qualified[2] or 'msg'}/{qualified[3]}"
    if match["bound"] is not None and base not in STRINGS:
        raise ValueError(f"[{text:.200}]: only strings have a maximum length")
    string_bound = _parse_size(match["bound"], text) if match["bound"] is not None else 0
    if match["array"] is None:
        return FieldType(base, Length.SINGLE, 0, string_bound)
    if match["size"] is None:
        if match["bounded"] is not None:
            raise ValueError(f"[{text:.200}] lacks the maximum number of elements")
        return FieldType(base, Length.UNBOUNDED, 0, string_bound)
    length = Length.FIXED if match["bounded"] is None else Length.BOUNDED
    return FieldType(base, length, _parse_size(match["size"], text), string_bound)


def _parse_size(digits: str, text: str) -> int:
    size = int(digits)
    if not 1 <= size <= MAX_SIZE:
        raise ValueError(f"[{text:.200}]: sizes are from 1 to {MAX_SIZE}")
    return size
