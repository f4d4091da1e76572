"""Generates the constructors of message classes (G17, G18)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pyros1.msgs.base import Message
from pyros1.msgs.generator import Fields, FunctionBuilder, field_groups, fields_of, split_type
from pyros1.msgs.spec import STRUCT_CODES

_MIN_NAMES_FOR_SET = 50
"""Minimum number of field names for which a set is used to look them up; with fewer, a list is as fast."""


def make_init(cls: type[Message]) -> Callable[..., None]:
    """Generate and return the ``__init__`` of a message class."""
    if not hasattr(cls, "_type"):
        return set_slots  # a class that the program defines, without a message definition
    builder = FunctionBuilder(cls)
    self_name, args, kwds = "self", "args", "kwds"  # not made unique, since they are visible in the signature
    groups = field_groups(cls)
    arranged_values = f"{builder.ref(arrange_arguments)}({builder.ref(cls)}, {args}, {kwds})"
    if len(groups) > 1:
        builder.lines += [f"{builder.ref(_make_part(cls, group), 'part')}({self_name})" for group in groups]
        builder.emit(
            f"if {args} or {kwds}: {builder.ref(_set_given_fields)}({self_name}, {builder.ref(cls)}, {arranged_values})"
        )
        return builder.compile_function("init", [self_name, f"*{args}", f"**{kwds}"])
    with_args, without_args = FunctionBuilder(cls, builder.scope), FunctionBuilder(cls, builder.scope)
    values = [with_args.unique_name("value") for _ in cls.__slots__]
    with_args.emit(f"{', '.join(values)}, = {arranged_values}" if values else arranged_values)
    for (name, slot_type), value in zip(fields_of(cls), values, strict=True):
        with_args.emit(
            f"{self_name}.{name} = {_default_expression(with_args, cls, slot_type)} if {value} is None else {value}"
        )
    _fill_defaults(without_args, cls, self_name, fields_of(cls))
    builder.block(f"if {args} or {kwds}:", with_args.lines)
    builder.block("else:", without_args.lines)
    return builder.compile_function("init", [self_name, f"*{args}", f"**{kwds}"])


def _make_part(cls: type[Message], fields: Fields) -> Callable[[Any], None]:
    """Generate and return a function that sets some fields of a message to their defaults."""
    builder = FunctionBuilder(cls)
    target = builder.unique_name("m")
    _fill_defaults(builder, cls, target, fields)
    return builder.compile_function("part", [target])


def set_slots(message: Any, *args: Any, **kwds: Any) -> None:
    """Set the slots of a message whose class has no definition; slots without a value become None."""
    cls = type(message)
    values = arrange_arguments(cls, args, kwds) if args or kwds else (None,) * len(cls.__slots__)
    for name, value in zip(cls.__slots__, values, strict=True):
        setattr(message, name, value)


def _set_given_fields(message: Any, cls: type[Message], values: tuple[Any, ...]) -> None:
    """Set the fields for which an argument was given, i.e. whose value is not None."""
    for name, value in zip(cls.__slots__, values, strict=True):
        if value is not None:
            setattr(message, name, value)


def arrange_arguments(cls: type[Message], args: tuple[Any, ...], kwds: dict[str, Any]) -> tuple[Any, ...]:
    """Return constructor arguments in field order, with None for omitted arguments.

    Raises:
        TypeError, AttributeError: as for the constructor of the class.
    """
    slots = cls.__slots__
    if kwds:
        if args:
            raise TypeError("Message constructor may only use args OR keywords, not both")
        names = slots if len(slots) < _MIN_NAMES_FOR_SET else {*slots}
        for name in kwds:
            if name not in names:
                raise AttributeError(f"{name} is not an attribute of {cls.__name__}")
        return tuple(map(kwds.get, slots))
    if len(args) != len(slots):
        raise TypeError(f"Invalid number of arguments, args should be {list(slots)} args are{args}")
    return args


def _fill_defaults(builder: FunctionBuilder, cls: type[Message], target: str, fields: Fields) -> None:
    for name, slot_type in fields:
        base, length = split_type(slot_type)
        nested = cls._classes.get(base)
        if nested is not None and length is None and builder.reserve_inline(nested):
            variable = builder.unique_name("new")
            builder.emit(f"{target}.{name} = {variable} = {builder.new_object(builder.class_ref(base, nested))}")
            _fill_defaults(builder, nested, variable, fields_of(nested))
        else:
            builder.emit(f"{target}.{name} = {_default_expression(builder, cls, slot_type)}")


def _default_expression(builder: FunctionBuilder, cls: type[Message], slot_type: str) -> str:
    """Return the Python expression for a field's default value (G18)."""
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
        value = f"{builder.class_ref(base, cls._classes.get(base))}()"
        if length is not None:
            return f"[{value} for {builder.unique_name('i')} in range({length})]"
    return value if length is None else f"[{value}] * {length}"
