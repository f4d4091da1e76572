"""Generates the constructors of message classes (G17, G18)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pyros1.msgs.base import Message
from pyros1.msgs.source import Source, split_type
from pyros1.msgs.spec import STRUCT_CODES


def make_init(cls: type[Message]) -> Callable[..., None]:
    """Generate ``__init__``."""
    source = Source(cls)
    names = list(cls.__slots__)
    values = [_default(source, cls, slot_type) for slot_type in cls._slot_types]
    source.names["arrange"] = arrange
    source.lines.append("if args or kwds:")
    source.lines.append(
        f"    {''.join(f'a_{name}, ' for name in names) or '_'} = arrange({source.ref(cls)}, args, kwds)"
    )
    for name, value in zip(names, values, strict=True):
        source.lines.append(f"    self.{name} = {value} if a_{name} is None else a_{name}")
    source.lines.append("else:")
    plain = Source(cls)
    plain._known, plain.names, plain._count = source._known, source.names, 1000
    _fill_defaults(plain, cls, "self")
    source.lines += [f"    {line}" for line in plain.lines or ["pass"]]
    return source.function("__init__(self, *args, **kwds)")


def arrange(cls: type[Message], args: tuple[Any, ...], kwds: dict[str, Any]) -> tuple[Any, ...]:
    """Return constructor arguments in field order, None for those not given.

    Raises:
        TypeError, AttributeError: as the class's constructor.
    """
    slots = cls.__slots__
    if kwds:
        if args:
            raise TypeError("Message constructor may only use args OR keywords, not both")
        for name in kwds:
            if name not in slots:
                raise AttributeError(f"{name} is not an attribute of {cls.__name__}")
        return tuple(map(kwds.get, slots))
    if len(args) != len(slots):
        raise TypeError(f"Invalid number of arguments, args should be {list(slots)} args are{args}")
    return args


def _fill_defaults(source: Source, cls: type[Message], target: str) -> None:
    for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
        base, length = split_type(slot_type)
        nested = cls._classes.get(base)
        if nested is not None and length is None and source.inlines(nested):
            local = source.local()
            source.lines.append(f"{target}.{name} = {local} = new({source.ref(nested)})")
            _fill_defaults(source, nested, local)
        else:
            source.lines.append(f"{target}.{name} = {_default(source, cls, slot_type)}")


def _default(source: Source, cls: type[Message], slot_type: str) -> str:
    """Return the expression of a field's default value (G18)."""
    base, length = split_type(slot_type)
    if length is not None and STRUCT_CODES.get(base) == "B" and base != "bool":
        return "b''" if length < 0 else f"bytes({length})"
    if length == -1:
        return "[]"
    if base == "string":
        value = "''"
    elif base in STRUCT_CODES:
        value = "False" if base == "bool" else "0.0" if base.startswith("float") else "0"
    else:
        value = {"time": "Time", "duration": "Duration"}.get(base) or source.ref(cls._classes[base])
        value += "()"
    if length is None:
        return value
    return f"[{value} for _ in range({length})]" if value.endswith("()") else f"[{value}] * {length}"
