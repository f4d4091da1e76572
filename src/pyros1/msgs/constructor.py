"""Generates the constructors of message classes (G17, G18)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pyros1.msgs.base import Message
from pyros1.msgs.generator import Fields, Source, fields_of, parts_of, split_type
from pyros1.msgs.spec import STRUCT_CODES

_SET_THRESHOLD = 50
"""Number of names from which a set is made for the search: with fewer, a list is as fast."""


def make_init(cls: type[Message]) -> Callable[..., None]:
    """Generate ``__init__``."""
    if not hasattr(cls, "_type"):
        return set_all  # a program's own class, without a definition
    source = Source(cls)
    me, args, kwds = "self", "args", "kwds"  # without a number, since these names show in the signature
    parts = parts_of(cls)
    arranged = f"{source.ref(arrange)}({source.ref(cls)}, {args}, {kwds})"
    if len(parts) > 1:
        source.lines += [f"{source.ref(_make_part(cls, part), 'part')}({me})" for part in parts]
        source.emit(f"if {args} or {kwds}: {source.ref(_assign)}({me}, {source.ref(cls)}, {arranged})")
        return source.function("init", [me, f"*{args}", f"**{kwds}"])
    given, plain = Source(cls, source.scope), Source(cls, source.scope)
    values = [given.fresh("value") for _ in cls.__slots__]
    given.emit(f"{', '.join(values)}, = {arranged}" if values else arranged)
    for (name, slot_type), value in zip(fields_of(cls), values, strict=True):
        given.emit(f"{me}.{name} = {_default(given, cls, slot_type)} if {value} is None else {value}")
    _fill_defaults(plain, cls, me, fields_of(cls))
    source.block(f"if {args} or {kwds}:", given.lines)
    source.block("else:", plain.lines)
    return source.function("init", [me, f"*{args}", f"**{kwds}"])


def _make_part(cls: type[Message], fields: Fields) -> Callable[[Any], None]:
    """Generate a function that sets some fields of a message to their defaults."""
    source = Source(cls)
    target = source.fresh("m")
    _fill_defaults(source, cls, target, fields)
    return source.function("part", [target])


def set_all(message: Any, *args: Any, **kwds: Any) -> None:
    """Set the slots of a message whose class has no definition; those not given are None."""
    cls = type(message)
    values = arrange(cls, args, kwds) if args or kwds else (None,) * len(cls.__slots__)
    for name, value in zip(cls.__slots__, values, strict=True):
        setattr(message, name, value)


def _assign(message: Any, cls: type[Message], values: tuple[Any, ...]) -> None:
    for name, value in zip(cls.__slots__, values, strict=True):
        if value is not None:
            setattr(message, name, value)


def arrange(cls: type[Message], args: tuple[Any, ...], kwds: dict[str, Any]) -> tuple[Any, ...]:
    """Return constructor arguments in field order, None for those not given.

    Raises:
        TypeError, AttributeError: as the class's constructor.
    """
    slots = cls.__slots__
    if kwds:
        if args:
            raise TypeError("Message constructor may only use args OR keywords, not both")
        known = slots if len(slots) < _SET_THRESHOLD else {*slots}
        for name in kwds:
            if name not in known:
                raise AttributeError(f"{name} is not an attribute of {cls.__name__}")
        return tuple(map(kwds.get, slots))
    if len(args) != len(slots):
        raise TypeError(f"Invalid number of arguments, args should be {list(slots)} args are{args}")
    return args


def _fill_defaults(source: Source, cls: type[Message], target: str, fields: Fields) -> None:
    for name, slot_type in fields:
        base, length = split_type(slot_type)
        nested = cls._classes.get(base)
        if nested is not None and length is None and source.inlines(nested):
            local = source.fresh("new")
            source.emit(f"{target}.{name} = {local} = {source.new(source.class_of(base, nested))}")
            _fill_defaults(source, nested, local, fields_of(nested))
        else:
            source.emit(f"{target}.{name} = {_default(source, cls, slot_type)}")


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
        value = f"{source.class_of(base, cls._classes.get(base))}()"
        if length is not None:
            return f"[{value} for {source.fresh('i')} in range({length})]"
    return value if length is None else f"[{value}] * {length}"
