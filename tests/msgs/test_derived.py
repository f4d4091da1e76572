"""Message classes that programs derive from others."""

from __future__ import annotations

import io
from typing import Any

import codec
import pytest

from pyros1.ground.errors import DeserializationError
from pyros1.msgs import from_definition
from pyros1.msgs.derived import encode, encode_frame, make_copy, make_decode


def made(text: str) -> Any:
    return from_definition("p/T", text)


def decode(cls: Any, body: bytes) -> Any:
    return make_decode(cls)(b"?" + body + b"?", 1, len(body) + 1)


def test_objects_are_of_the_derived_class_and_made_by_its_constructor() -> None:
    base = made("int32 a")

    class Own(base):
        def __init__(self, a: int = 0) -> None:
            super().__init__(a)
            self.more = "yes"

    message = decode(Own, codec.encode(base(5)))
    assert type(message) is Own
    assert (message.a, message.more) == (5, "yes")
    assert codec.encode(Own(6)) == codec.encode(base(6))


def test_its_own_functions_are_called() -> None:
    base = made("string s")

    class Own(base):
        def serialize(self, buff: Any) -> None:
            base(self.s + "!").serialize(buff)

        def deserialize(self, data: bytes) -> Any:
            super().deserialize(data)
            self.s = self.s.upper()
            return self

    assert encode(Own("a")) == codec.encode(base("a!"))
    assert encode_frame(Own("a")) == codec.encode_frame(base("a!"))
    assert decode(Own, codec.encode(base("a"))).s == "A"
    copy = make_copy(Own)(Own("a"))
    assert (type(copy), copy.s) == (base, "a!")


def test_the_way_of_numpy_msg() -> None:
    numpy = pytest.importorskip("numpy")
    base = made("float32[] f")

    class Own(base):
        __slots__ = base.__slots__
        _slot_types = base._slot_types

        def serialize(self, buff: Any) -> None:
            self.serialize_numpy(buff, numpy)

        def deserialize(self, data: bytes) -> Any:
            return self.deserialize_numpy(data, numpy)

    body = encode(Own(numpy.array([1, 2], numpy.float32)))
    assert body == codec.encode(base([1, 2]))
    message = decode(Own, body)
    assert (type(message), message.f.tolist()) == (Own, [1, 2])
    buffer = io.BytesIO()
    message.serialize(buffer)
    assert buffer.getvalue() == body


def test_its_errors_are_those_of_a_message_that_cannot_be_read() -> None:
    base = made("string s")

    class Own(base):
        def deserialize(self, data: bytes) -> Any:
            raise KeyError("k")

    with pytest.raises(DeserializationError, match="KeyError in Own: 'k'"):
        decode(Own, codec.encode(base("a")))
