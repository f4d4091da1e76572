"""Python source for the constructor and the codec of a message class.

The source is built from field names that the parser has checked (``[A-Za-z][A-Za-z0-9_]*``) and from names made here,
never from other text. Neighbouring values of fixed size share one ``struct.Struct``, across nested messages: these are
inlined up to a limit. The length prefixes of strings and arrays are part of the struct before them.

The fast path does not look for the cause of a failure. An encoder catches whatever a wrong value raises, a decoder
whatever wrong bytes raise, and ``check.py`` then walks the value or the bytes slowly to say which field is to blame. What a
decoder must check itself is what bounds memory and time: the number of elements against the bytes left, and that it
ended exactly where the message ends. (Reading behind ``end`` in a larger buffer is harmless: the position is then wrong.)
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

from pyros1.errors import DeserializationError, SerializationError
from pyros1.msgs import arrays
from pyros1.msgs.base import Message
from pyros1.msgs.check import explain, refusal
from pyros1.msgs.factory import MAX_EMPTY
from pyros1.msgs.spec import STRUCT_CODES
from pyros1.timing import Duration, Time

MAX_INLINE = 200
"""Most values that one function handles inline; what nested messages have beyond is left to their own functions."""

LARGE = 16384
"""Bodies from this size on are sent as a list of buffers, their large arrays not copied."""

_TIME_CODES = {"time": "I", "duration": "i"}
_WRONG_VALUE = (struct.error, SerializationError, AttributeError, TypeError, ValueError, OverflowError)
_WRONG_BYTES = (struct.error, DeserializationError, ValueError, OverflowError, TypeError)


def split_type(slot_type: str) -> tuple[str, int | None]:
    """Return base type and length of a ``_slot_types`` entry: None for a single value, -1 for an array of any length."""
    base, bracket, count = slot_type.partition("[")
    return base, None if not bracket else -1 if count == "]" else int(count[:-1])


def inline_size(cls: type[Message]) -> int:
    """Return how many values a function handles that inlines all messages nested in ``cls``, counted up to the limit."""
    total = 0
    for slot_type in cls._slot_types:
        base, length = split_type(slot_type)
        total += inline_size(cls._classes[base]) if length is None and base in cls._classes else 1
        if total > MAX_INLINE:
            return total
    return total


class _Source:
    """Lines of a function body and the objects that they refer to."""

    def __init__(self, cls: type[Message]) -> None:
        self.cls = cls
        self.lines: list[str] = []
        self.names: dict[str, Any] = {"new": object.__new__, "Time": Time, "Duration": Duration}
        self._known: dict[Any, str] = {}
        self._count = 0
        self.budget = MAX_INLINE

    def local(self) -> str:
        self._count += 1
        return f"x{self._count}"

    def ref(self, value: Any, key: Any = None) -> str:
        """Return the name under which the function sees ``value``."""
        key = id(value) if key is None else key
        if key not in self._known:
            self._known[key] = f"_{len(self._known)}"
            self.names[self._known[key]] = value
        return self._known[key]

    def pack(self, fmt: str) -> str:
        return self.ref(struct.Struct("<" + fmt).pack, ("pack", fmt))

    def unpack(self, fmt: str) -> str:
        return self.ref(struct.Struct("<" + fmt).unpack_from, ("unpack", fmt))

    def inlines(self, cls: type[Message]) -> bool:
        """Tell whether a nested message of this class is inlined, and count it."""
        size = inline_size(cls)
        if size > self.budget:
            return False
        self.budget -= size
        return True

    def function(self, header: str, guard: tuple[str, str] | None = None) -> Callable[..., Any]:
        lines = [f"def {header}:"]
        if guard is None:
            lines += [f"    {line}" for line in self.lines]
        else:
            lines += ["    try:", *(f"        {line}" for line in self.lines)]
            lines += [f"    except {guard[0]} as error:", f"        raise {guard[1]} from error"]
        code = compile("\n".join(lines), f"<codec of {self.cls._type}>", "exec")
        exec(code, self.names)  # noqa: S102  built above from validated identifiers only
        function: Callable[..., Any] = self.names[header.partition("(")[0]]
        return function


# -- constructor -------------------------------------------------------------------------------------------------------


def make_init(cls: type[Message]) -> Callable[..., None]:
    """Generate ``__init__``."""
    source = _Source(cls)
    names = list(cls.__slots__)
    values = [_default(source, cls, slot_type) for slot_type in cls._slot_types]
    source.names["arrange"] = arrange
    source.lines.append("if args or kwds:")
    source.lines.append(f"    {''.join(f'a_{name}, ' for name in names) or '_'} = arrange({source.ref(cls)}, args, kwds)")
    for name, value in zip(names, values, strict=True):
        source.lines.append(f"    self.{name} = {value} if a_{name} is None else a_{name}")
    source.lines.append("else:")
    plain = _Source(cls)
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
        raise TypeError(f"Invalid number of arguments, args should be {list(slots)} args are {args}")
    return args


def _fill_defaults(source: _Source, cls: type[Message], target: str) -> None:
    for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
        base, length = split_type(slot_type)
        nested = cls._classes.get(base)
        if nested is not None and length is None and source.inlines(nested):
            local = source.local()
            source.lines.append(f"{target}.{name} = {local} = new({source.ref(nested)})")
            _fill_defaults(source, nested, local)
        else:
            source.lines.append(f"{target}.{name} = {_default(source, cls, slot_type)}")


def _default(source: _Source, cls: type[Message], slot_type: str) -> str:
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


# -- encoder -----------------------------------------------------------------------------------------------------------


class _Encoder(_Source):
    """Collects the parts of the body: runs of fixed values, and pieces of bytes between them."""

    def __init__(self, cls: type[Message]) -> None:
        super().__init__(cls)
        self.parts: list[tuple[str, list[str]] | str] = []
        self.fixed = 0
        self.pieces: list[str] = []
        self.large = False

    def value(self, code: str, expression: str) -> None:
        if not self.parts or isinstance(self.parts[-1], str):
            self.parts.append(("", []))
        run = self.parts[-1]
        assert not isinstance(run, str)
        self.parts[-1] = (run[0] + code, [*run[1], expression])
        self.fixed += struct.calcsize("<" + code)

    def piece(self, expression: str) -> str:
        local = self.local()
        self.lines.append(f"{local} = {expression}")
        self.pieces.append(local)
        return local

    def message(self, cls: type[Message], owner: str) -> None:
        for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
            base, length = split_type(slot_type)
            expression = f"{owner}.{name}"
            if length is None:
                self._single(base, cls._classes.get(base), expression)
            else:
                self._array(base, length, cls._classes.get(base), expression)

    def _single(self, base: str, nested: type[Message] | None, expression: str) -> None:
        if base in STRUCT_CODES:
            self.value(STRUCT_CODES[base], expression)
        elif base == "string":
            text = self.piece(f"{expression}.encode()")
            self.value("I", f"len({text})")
            self.parts.append(text)
        elif nested is None:
            local = self.local()
            self.lines.append(f"{local} = {expression}")
            self.value(_TIME_CODES[base], f"{local}.secs")
            self.value(_TIME_CODES[base], f"{local}.nsecs")
        elif self.inlines(nested):
            local = self.local()
            self.lines.append(f"{local} = {expression}")
            self.message(nested, local)
        else:
            self.parts.append(self.piece(f"{self.ref(nested._encode)}({expression})"))

    def _array(self, base: str, length: int, nested: type[Message] | None, expression: str) -> None:
        code = STRUCT_CODES.get(base)
        local = self.local()
        self.lines.append(f"{local} = {expression}")
        if code == "B" and base != "bool":
            self.lines.append(f"if {local}.__class__ is not bytes: {local} = {self.ref(arrays.octets)}({local}, {length})")
            if length >= 0:
                # Stock pads bytes that are too short; too many it would cut, which hides an error.
                self.lines.append(f"if len({local}) > {length}: raise ValueError('too long')")
                self.value(f"{length}s", local)
                return
            self.large = True
            self.pieces.append(local)
            self.value("I", f"len({local})")
            self.parts.append(local)
            return
        if length >= 0:
            self.lines.append(f"if len({local}) != {length}: raise ValueError('wrong length')")
            if code is not None and length:
                self.value(f"{length}{code}", f"*{local}")
                return
        else:
            self.value("I", f"len({local})")
        if code is not None:
            packers = self.ref(arrays.Packers(code), ("packers", code))
            self.large = True
            piece = self.piece(f"{packers}.pack({local}) if len({local}) > 256 else {packers}[len({local})](*{local})")
        elif base == "string":
            piece = self.piece(f"{self.ref(arrays.pack_strings)}({local})")
        elif nested is None:
            piece = self.piece(f"{self.ref(arrays.pack_times)}({local}, '{_TIME_CODES[base]}')")
        else:
            encode = self.ref(nested._encode)
            piece = self.piece(f"b''.join([{encode}(e) for e in {local}])")
        self.parts.append(piece)


def make_encode_frame(cls: type[Message]) -> Callable[[Any], Any]:
    """Generate ``_encode_frame``."""
    return _make_encoder(cls, frame=True)


def make_encode(cls: type[Message]) -> Callable[[Any], bytes]:
    """Generate ``_encode``."""
    return _make_encoder(cls, frame=False)


def _make_encoder(cls: type[Message], *, frame: bool) -> Callable[[Any], Any]:
    source = _Encoder(cls)
    if frame:
        source.value("I", "size")
    source.message(cls, "m")
    sizes = [f"len({piece})" for piece in source.pieces]
    total = " + ".join([str(source.fixed - 4), *sizes] if source.fixed > 4 or not sizes else sizes)
    expressions = []
    for part in source.parts:
        if isinstance(part, str):
            expressions.append(part)
        else:
            values = ", ".join("size" if value == "size" else value for value in part[1])
            expressions.append(f"{source.pack(part[0])}({values})")
    if frame:
        source.lines.append(f"size = {total}")
    joined = ", ".join(expressions)
    if len(expressions) <= 2 and not source.large:
        source.lines.append(f"return {' + '.join(expressions) or repr(b'')}")
    elif frame and source.large:
        source.lines.append(f"if size < {LARGE}: return b''.join(({joined}))")
        source.lines.append(f"return {source.ref(arrays.gather)}(({joined}), {LARGE})")
    else:
        source.lines.append(f"return b''.join(({joined},))")
    source.names.update(WrongValue=_WRONG_VALUE, refusal=refusal)
    return source.function("encode(m)", ("WrongValue", f"refusal({source.ref(cls)}, m, error)"))


# -- decoder -----------------------------------------------------------------------------------------------------------


class _Decoder(_Source):
    """Emits statements in field order; ``self.at`` is the name of the variable that holds the position."""

    def __init__(self, cls: type[Message]) -> None:
        super().__init__(cls)
        self.at = "start"
        self.codes: list[str] = []
        self.targets: list[str] = []
        self.after: list[str] = []

    def value(self, code: str, target: str) -> None:
        self.codes.append(code)
        self.targets.append(target)

    def flush(self) -> None:
        """Emit the unpacking of the values collected, and move the position behind them."""
        if not self.codes:
            return
        fmt = "".join(self.codes)
        self.lines.append(f"{', '.join(self.targets)}, = {self.unpack(fmt)}(buf, {self.at})")
        self.lines += self.after
        self.move(struct.calcsize("<" + fmt))
        self.codes, self.targets, self.after = [], [], []

    def move(self, size: int) -> None:
        self.lines.append(f"p = {self.at} + {size}")
        self.at = "p"

    def message(self, cls: type[Message], owner: str) -> None:
        for name, slot_type in zip(cls.__slots__, cls._slot_types, strict=True):
            base, length = split_type(slot_type)
            target = f"{owner}.{name}"
            if length is None:
                self._single(base, cls._classes.get(base), target)
            else:
                self._array(base, length, cls._classes.get(base), target)

    def _single(self, base: str, nested: type[Message] | None, target: str) -> None:
        if base in STRUCT_CODES:
            self.value("?" if base == "bool" else STRUCT_CODES[base], target)
        elif base == "string":
            self.value("I", "n")
            self.flush()
            self.lines.append(f"q = {self.at} + n")
            self.lines.append(f"{target} = str(buf[{self.at}:q], 'utf-8')")
            self.at = "q"
        elif nested is None:
            local = self.local()
            self.lines.append(f"{target} = {local} = new({base.capitalize()})")
            self.value(_TIME_CODES[base], f"{local}.secs")
            self.value(_TIME_CODES[base], f"{local}.nsecs")
            self.after.append(f"if not -1 < {local}.nsecs < 1000000000: {local}.canon()")
        elif self.inlines(nested):
            local = self.local()
            self.lines.append(f"{target} = {local} = new({self.ref(nested)})")
            self.message(nested, local)
        else:
            self.flush()
            self.lines.append(f"{target}, q = {self.ref(nested._read)}(buf, {self.at}, end)")
            self.at = "q"

    def _array(self, base: str, length: int, nested: type[Message] | None, target: str) -> None:
        code = "?" if base == "bool" else STRUCT_CODES.get(base)
        count = "n" if length < 0 else str(length)
        if code == "B" and length >= 0:
            self.value(f"{length}s", target)
            return
        if length < 0:
            self.value("I", "n")
        self.flush()
        if code == "B":
            self.lines.append(f"q = {self.at} + n")
            self.lines.append(f"{target} = {self.ref(arrays.to_bytes)}(buf[{self.at}:q])")
            self.at = "q"
        elif code is not None:
            self._numbers(code, length, target)
        elif base == "string":
            self.lines.append(f"{target}, q = {self.ref(arrays.read_strings)}(buf, {self.at}, {count}, end)")
            self.at = "q"
        elif nested is None or nested._fixed_size is not None:
            size = 8 if nested is None else nested._fixed_size
            time_class = {"time": Time, "duration": Duration}.get(base)
            if not size:
                assert nested is not None
                self.lines.append(f"if {count} > {MAX_EMPTY}: raise ValueError('count')")
                self.lines.append(f"{target} = [{self.ref(nested)}() for _ in range({count})]")
                return
            self.lines.append(f"q = {self.at} + {count} * {size}" if length < 0 else f"q = {self.at} + {length * size}")
            self.lines.append("if q > end: raise ValueError('count')")
            if nested is None:
                times = self.ref(arrays.read_times)
                fmt = _TIME_CODES[base]
                self.lines.append(f"{target} = {times}(buf, {self.at}, {count}, '{fmt}', {self.ref(time_class)})")
            else:
                decode = self.ref(nested._decode)
                self.lines.append(f"{target} = [{decode}(buf, i, i + {size}) for i in range({self.at}, q, {size})]")
            self.at = "q"
        else:
            least = nested._min_size
            items = self.local()
            if length < 0:
                self.lines.append(f"if n > (end - {self.at}) // {least}: raise ValueError('count')")
            self.lines.append(f"{target} = {items} = []")
            self.lines.append(f"q = {self.at}")
            self.lines.append(f"for _ in range({count}):")
            self.lines.append(f"    item, q = {self.ref(nested._read)}(buf, q, end)")
            self.lines.append(f"    {items}.append(item)")
            self.at = "q"

    def _numbers(self, code: str, length: int, target: str) -> None:
        if length >= 0:
            read = f"{self.unpack(f'{length}{code}')}(buf, {self.at})"
            size = struct.calcsize(f"<{length}{code}")
        else:
            size = struct.calcsize("<" + code)
            self.lines.append(f"q = {self.at} + n * {size}" if size > 1 else f"q = {self.at} + n")
            self.lines.append("if q > end: raise ValueError('count')")
            unpackers = self.ref(arrays.Unpackers(code), ("unpackers", code))
            read = f"{unpackers}[n](buf, {self.at})"
        self.lines.append(f"{target} = list({read})" if code == "?" else f"{target} = {read}")
        if length >= 0:
            self.move(size)
        else:
            self.at = "q"


def make_decode(cls: type[Message]) -> Callable[[Any, int, int], Any]:
    """Generate ``_decode``."""
    source = _decoder(cls)
    if cls._fixed_size is not None:
        source.lines.insert(0, f"if end - start != {cls._fixed_size}: raise ValueError('size')")
        # The position needs no second look: drop its last computation.
        if source.lines[-1].startswith("p = "):
            source.lines.pop()
    else:
        source.lines.append(f"if {source.at} != end: raise ValueError('size')")
    source.lines.append("return m")
    source.names.update(WrongBytes=_WRONG_BYTES, explain=explain)
    return source.function("decode(buf, start, end)", ("WrongBytes", f"explain({source.ref(cls)}, buf, start, end)"))


def make_read(cls: type[Message]) -> Callable[[Any, int, int], tuple[Any, int]]:
    """Generate ``_read``; its errors are for its caller to explain, who knows where the whole message begins."""
    source = _decoder(cls)
    source.lines.append(f"if {source.at} > end: raise ValueError('size')")
    source.lines.append(f"return m, {source.at}")
    return source.function("read(buf, start, end)")


def _decoder(cls: type[Message]) -> _Decoder:
    source = _Decoder(cls)
    source.lines.append(f"m = new({source.ref(cls)})")
    source.message(cls, "m")
    source.flush()
    return source
