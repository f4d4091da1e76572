"""Definitions of messages: types, fields and constants (https://wiki.ros.org/msg)."""

from __future__ import annotations

from typing import Any

from genmsg.base import EXT_MSG, MSG_DIR, SEP, InvalidMsgSpec, log
from genmsg.names import is_legal_resource_base_name, is_legal_resource_name, package_resource_name, resource_name
from pyros1.drop_in.module_attributes import module_getattr

HEADER = "Header"
HEADER_FULL_NAME = "std_msgs/Header"
TIME = "time"
DURATION = "duration"
TIME_MSG = "uint32 secs\nuint32 nsecs"
DURATION_MSG = "int32 secs\nint32 nsecs"
PRIMITIVE_TYPES = (
    "int8 uint8 int16 uint16 int32 uint32 int64 uint64 float32 float64 string bool char byte".split()  # noqa: SIM905
)
BUILTIN_TYPES = [*PRIMITIVE_TYPES, TIME, DURATION]

__getattr__ = module_getattr(__name__)


def bare_msg_type(msg_type: str | None) -> str | None:
    """Return the name of a type without the brackets of an array."""
    return None if msg_type is None else msg_type.partition("[")[0]


def resolve_type(msg_type: str, package_context: str) -> str:
    """Return the full name of a type used in a package; the brackets of an array are kept."""
    bare = msg_type.partition("[")[0]
    if bare in BUILTIN_TYPES:
        return msg_type
    if bare == HEADER:
        return HEADER_FULL_NAME + msg_type[len(bare) :]
    return msg_type if SEP in bare else f"{package_context}{SEP}{msg_type}"


def parse_type(msg_type: str) -> tuple[str, bool, int | None]:
    """Return the name of a type without brackets, whether it is an array, and its length (None if that is variable).

    Raises:
        ValueError: the type is not legal.
    """
    if not msg_type:
        raise ValueError("Invalid empty type")
    base, bracket, after_bracket = msg_type.partition("[")
    if not bracket:
        return msg_type, False, None
    count = after_bracket[:-1]
    if not after_bracket.endswith("]") or "[" in after_bracket or (count and not count.isdigit()):
        raise ValueError(f"Invalid type [{msg_type}]")
    return base, True, int(count) if count else None


def is_valid_msg_type(x: str | None) -> bool:
    """Return whether a type's name is legal; the type need not exist."""
    if not x or len(x) != len(x.strip()):
        return False
    try:
        base, _, _ = parse_type(x)
    except ValueError:
        return False
    return is_legal_resource_name(base)


def is_valid_constant_type(x: str) -> bool:
    """Return whether a type is allowed for constants."""
    return x in PRIMITIVE_TYPES


def is_valid_msg_field_name(x: str | None) -> bool:
    """Return whether a field's name is legal."""
    return is_legal_resource_base_name(x)


def is_header_type(msg_type: str) -> bool:
    """Return whether a type is a header."""
    return msg_type in (HEADER, HEADER_FULL_NAME, "roslib/Header")


def is_builtin(msg_type_name: str) -> bool:
    """Return whether a type is built in."""
    return msg_type_name in BUILTIN_TYPES


class Constant:
    """A constant in a definition.

    Args:
        type_: its type.
        name: its name.
        val: its value.
        val_text: its value as written in the definition.
    """

    __slots__ = ["type", "name", "val", "val_text"]  # noqa: RUF023  in stock's order

    def __init__(self, type_: str, name: str, val: Any, val_text: str) -> None:
        if type_ is None or name is None or val is None or val_text is None:
            raise ValueError("Constant must have non-None parameters")
        self.type = type_
        self.name = name.strip()
        self.val = val
        self.val_text = val_text

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Constant) and all(
            getattr(self, attribute) == getattr(other, attribute) for attribute in ("type", "name", "val")
        )

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"{self.type} {self.name}={self.val}"

    __str__ = __repr__


class Field:
    """A field in a definition.

    Args:
        name: its name.
        type: its type.

    Attributes:
        base_type: the type without brackets.
        is_array, array_len: whether the field is an array, and the array's length (None if it is variable).
        is_header: whether the field is a header.
        is_builtin: whether the type, without brackets, is built in.
    """

    def __init__(self, name: str, type: str) -> None:
        self.name = name
        self.type = type
        self.base_type, self.is_array, self.array_len = parse_type(type)
        self.is_header = is_header_type(type)
        self.is_builtin = is_builtin(self.base_type)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Field) and (self.name, self.type) == (other.name, other.type)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"[{self.name}, {self.type}, {self.base_type}, {self.is_array}, {self.array_len}]"


class MsgSpec:
    """A message's definition.

    Args:
        types: types of the fields.
        names: names of the fields.
        constants: the constants.
        text: the definition as written.
        full_name: ``package/Type``.
        package: the package.
        short_name: the name without the package.

    Raises:
        InvalidMsgSpec: a type is not legal, a name occurs twice, or there are not as many types as names.
    """

    def __init__(
        self,
        types: list[str],
        names: list[str],
        constants: list[Constant],
        text: str,
        full_name: str,
        package: str = "",
        short_name: str = "",
    ) -> None:
        duplicates = sorted({name for name in names if names.count(name) > 1})
        if duplicates:
            raise InvalidMsgSpec(f"Duplicate field names [{', '.join(duplicates)}] in message")
        if len(types) != len(names):
            raise InvalidMsgSpec(f"len of fields [{len(types)}] does not equal len of names [{len(names)}]")
        for type_name in types:
            if not is_valid_msg_type(type_name):
                raise InvalidMsgSpec(f"invalid field: {type_name}")
        self.types = types
        self.names = names
        self.constants = constants
        self.text = text
        self.full_name = full_name
        own_package, own_name = package_resource_name(full_name)
        self.package = package or own_package
        self.short_name = short_name or own_name
        self._parsed_fields = [Field(name, type_name) for name, type_name in zip(names, types, strict=True)]

    def fields(self) -> list[tuple[str, str]]:
        """Return (type, name) of all fields."""
        return list(zip(self.types, self.names, strict=True))

    def parsed_fields(self) -> list[Field]:
        """Return all fields."""
        return self._parsed_fields

    def has_header(self) -> bool:
        """Return whether the first field is the header that publishers fill in."""
        return bool(self.fields()) and self.names[0] == "header" and is_header_type(self.types[0])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, MsgSpec):
            return False
        mine, theirs = (
            (spec.types, spec.names, spec.text, spec.full_name, spec.short_name, spec.package) for spec in (self, other)
        )
        return mine == theirs and self.constants == other.constants

    def __ne__(self, other: object) -> bool:
        return not self == other

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        constants = f"{self.constants!r}, " if self.constants else ""
        return f"MsgSpec[{constants}{self.types!r}, {self.names!r}]"

    def __str__(self) -> str:
        return self.text
