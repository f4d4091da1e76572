"""Numeric arrays as numpy arrays (G23)."""

from __future__ import annotations

import io
from typing import Any

import codec
import pytest

from pyros1.msgs import from_definition
from pyros1.msgs.base import nested_classes

numpy = pytest.importorskip("numpy")
SEPARATOR = "=" * 80


def test_decode_to_numpy_and_encode_from_it() -> None:
    cls: Any = from_definition(
        "p/T", f"float32[] f\nuint8[] u\nbool[2] b\nstring[] s\nA[] a\n{SEPARATOR}\nMSG: p/A\nint16[] i"
    )
    plain = cls((1.0, 2.5), b"ab", [True, False], ["x"], [nested_classes(cls)["p/A"]((1, -2))])
    data = codec.encode(plain)
    message = cls().deserialize_numpy(data, numpy)
    assert (message.f.dtype, message.u, message.b.dtype) == (numpy.float32, b"ab", numpy.bool_)
    assert message.a[0].i.tolist() == [1, -2] and message.s == ["x"]
    buffer = io.BytesIO()
    message.serialize_numpy(buffer, numpy)
    assert buffer.getvalue() == data
    assert message == cls().deserialize_numpy(data, numpy)


def test_large_arrays_and_other_dtypes() -> None:
    cls: Any = from_definition("p/T", "float64[] x\nint64[] i\nuint8[] u")
    numbers = numpy.arange(1000)
    expected = codec.encode(cls(tuple(map(float, range(1000))), tuple(range(1000)), bytes(1000)))
    assert codec.encode(cls(numbers.astype("f8"), numbers.astype("i8"), numpy.zeros(1000, "u1"))) == expected
    assert codec.encode(cls(numbers.astype("f4"), numbers.astype("i2"), numpy.zeros((10, 100), "u1"))) == expected
    every_second = numpy.arange(2000)[::2].astype("f8")
    assert codec.encode(cls(numpy.repeat(every_second, 2)[::2], [], b"")) == codec.encode(
        cls(list(every_second), [], b"")
    )


def test_arrays_of_other_lengths_are_not_equal() -> None:
    cls: Any = from_definition("p/T", "float32[] x")
    ones = cls(numpy.ones(3, "f4"))
    assert ones == cls([1.0, 1.0, 1.0]) and cls((1.0, 1.0, 1.0)) == ones
    for other in ([1.0], [], [1.0, 1.0], numpy.ones(1, "f4"), numpy.ones((3, 2), "f4")):
        assert ones != cls(other) and cls(other) != ones


def test_memoryviews_of_every_number_type() -> None:
    from pyros1.msgs.array_views import memoryview_view

    types = "int8 uint8 int16 uint16 int32 uint32 int64 uint64 float32 float64 bool"
    cls: Any = from_definition("p/T", "\n".join(f"{name}[] {name}s\n{name}[2] {name}2" for name in types.split()))
    plain = cls()
    for name in types.split():
        values = [True, False, True] if name == "bool" else [1.0, 2.0, 3.0] if "f" in name else [1, 2, 3]
        setattr(plain, name + "s", values)
    for name in types.split():
        zero = False if name == "bool" else 0
        setattr(plain, name + "2", [zero, zero])
    body = b"?" + codec.encode(plain)
    message = codec.decode_arrays(cls, body, 1, len(body), memoryview_view)
    for name in types.split():
        for field in (name + "s", name + "2"):
            view = getattr(message, field)
            assert isinstance(view, memoryview) and view.readonly and list(view) == list(getattr(plain, field)), field
    assert codec.encode(message) == body[1:]
