"""Builds the Python source of message classes' constructors and codecs: the code that their generators share.

Every name in the source, except for attributes and builtins, is created by `Scope.unique_name`. It ends in a number
that no other name in the function has, and no builtin or keyword has this form. Names from a definition, which the
parser has checked (``[A-Za-z][A-Za-z0-9_]*``), only occur after a dot.

Adjacent values of fixed size share one ``struct.Struct``, even across nested messages, which are inlined up to a limit.
The length prefixes of strings and arrays are part of the preceding struct.
"""

from __future__ import annotations

import itertools
import struct
from collections.abc import Callable, Sequence
from typing import Any

from pyros1.ground.timing import Duration, Time
from pyros1.msgs import arrays
from pyros1.msgs.base import Message

MAX_INLINE_VALUES = 200
"""Maximum number of values that one function handles inline; beyond that, nested messages have functions of their own.
"""

MAX_FIELDS_PER_FUNCTION = 500
"""Maximum number of fields that one function handles; more fields are split among several functions, since Python's
compiler needs several kilobytes for each line of a function.
"""

TIME_CODES = {"time": "I", "duration": "i"}
"""Struct code of seconds and nanoseconds, for times and durations."""

TIME_CLASSES: dict[str, type[Time | Duration]] = {"time": Time, "duration": Duration}


def split_type(slot_type: str) -> tuple[str, int | None]:
    """Return the base type and the length in a ``_slot_types`` entry; for the length, see
    :class:`pyros1.msgs.spec.Field`.
    """
    base, bracket, count = slot_type.partition("[")
    return base, None if not bracket else -1 if count == "]" else int(count[:-1])


Fields = Sequence[tuple[str, str]]
"""Names and types of fields, as in ``__slots__`` and ``_slot_types``."""


def fields_of(cls: type[Message]) -> Fields:
    """Return all fields of a message class."""
    return list(zip(cls.__slots__, cls._slot_types, strict=True))


def field_groups(cls: type[Message]) -> list[Fields]:
    """Split a message class's fields into one list per function; most classes need only one."""
    fields = fields_of(cls)
    return [fields[first : first + MAX_FIELDS_PER_FUNCTION] for first in range(0, len(fields), MAX_FIELDS_PER_FUNCTION)]


def inline_size(cls: type[Message]) -> int:
    """Return the number of values and messages that inlining ``cls`` would add; counting stops at the limit."""
    total = 0
    for slot_type in cls._slot_types:
        base, length = split_type(slot_type)
        total += 1  # a message counts as well, since it may be empty
        if length is None and base in cls._classes:
            total += inline_size(cls._classes[base])
        if total > MAX_INLINE_VALUES:
            break
    return total


class Scope:
    """The scope of one generated function: its names, and the number of values that may still be inlined.

    Attributes:
        objects: the objects that the function refers to, by name.
        budget: number of values that may still be inlined.
    """

    def __init__(self) -> None:
        self.objects: dict[str, Any] = {}
        self.budget = MAX_INLINE_VALUES
        self._names: dict[Any, str] = {}
        self._numbers = itertools.count(1)

    def unique_name(self, hint: str) -> str:
        """Return a name that is unique in the function.

        Args:
            hint: the beginning of the name, an identifier.
        """
        return f"{hint}_{next(self._numbers)}"

    def ref(self, value: Any, hint: str, key: Any) -> str:
        """Return the name of an object in the function. Objects with the same key share the name of the first one."""
        name = self._names.get(key)
        if name is None:
            name = self._names[key] = self.unique_name(hint)
            self.objects[name] = value
        return name


class FunctionBuilder:
    """Collects the lines of a function body.

    Args:
        cls: the message class.
        scope: the scope of the enclosing function; None for a new scope.
    """

    def __init__(self, cls: type[Message], scope: Scope | None = None) -> None:
        self.cls = cls
        self.scope = Scope() if scope is None else scope
        self.unique_name = self.scope.unique_name
        self.lines: list[str] = []

    def emit(self, line: str) -> None:
        self.lines.append(line)

    def block(self, header: str, lines: Sequence[str]) -> None:
        """Emit a compound statement."""
        self.lines.append(header)
        self.lines += [f"    {line}" for line in lines or ["pass"]]

    def assign(self, hint: str, expression: str) -> str:
        """Emit an assignment to a new variable; return its name."""
        variable = self.unique_name(hint)
        self.lines.append(f"{variable} = {expression}")
        return variable

    def ref(self, value: Any, hint: str = "ref", key: Any = None) -> str:
        """Return the name of ``value`` in the function.

        Args:
            value: any object.
            hint: the beginning of the name.
            key: objects with the same key share a name; None for the object's identity.
        """
        return self.scope.ref(value, hint, id(value) if key is None else key)

    def new_object(self, cls: str) -> str:
        """Return the expression for a new object without fields; ``cls`` is the name of its class."""
        return f"{self.ref(object.__new__, 'new')}({cls})"

    def class_ref(self, base: str, nested: type[Message] | None) -> str:
        """Return the name, in the function, of the class of a field that is a message, time or duration."""
        return self.ref(TIME_CLASSES[base] if nested is None else nested, "cls")

    def pack(self, struct_format: str) -> str:
        return self.ref(struct.Struct("<" + struct_format).pack, "pack", ("pack", struct_format))

    def unpack(self, struct_format: str) -> str:
        return self.ref(struct.Struct("<" + struct_format).unpack_from, "unpack", ("unpack", struct_format))

    def packers(self, base: str, code: str) -> str:
        packers_class = arrays.BoolPackers if base == "bool" else arrays.Packers
        return self.ref(packers_class(code), "packers", ("packers", packers_class, code))

    def can_inline(self, cls: type[Message]) -> bool:
        """Return whether a nested message of this class can be inlined."""
        return inline_size(cls) <= self.scope.budget

    def reserve_inline(self, cls: type[Message]) -> bool:
        """Reduce the budget by a nested message of this class if it can be inlined; return whether it can."""
        size = inline_size(cls)
        if size > self.scope.budget:
            return False
        self.scope.budget -= size
        return True

    def compile_function(
        self,
        name: str,
        parameters: Sequence[str],
        errors: tuple[type[Exception], ...] = (),
        on_error: Callable[[str], str] | None = None,
    ) -> Callable[..., Any]:
        """Compile and return the function.

        Args:
            name: the beginning of the function's name.
            parameters: the names of its parameters.
            errors: the exceptions that the body raises for wrong input.
            on_error: given the name of such an exception, returns the expression to return then.
        """
        body = FunctionBuilder(self.cls, self.scope)
        if on_error is None:
            body.lines = self.lines
        else:
            error = self.unique_name("error")
            body.block("try:", self.lines)
            body.block(f"except {self.ref(errors, 'errors')} as {error}:", [f"return {on_error(error)}"])
        definition = FunctionBuilder(self.cls, self.scope)
        name = self.unique_name(name)
        definition.block(f"def {name}({', '.join(parameters)}):", body.lines)
        code = compile("\n".join(definition.lines), f"<codec of {self.cls._type}>", "exec")
        exec(code, self.scope.objects)
        function: Callable[..., Any] = self.scope.objects[name]
        return function
