"""Generated encoders and decoders: bytes, limits, errors (G17-G23)."""

from __future__ import annotations

import contextlib
import io
import struct
import tracemalloc
from typing import Any

import codec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from message_strategies import messages

from pyros1.ground.errors import DeserializationError, LengthError, MessageError, SerializationError
from pyros1.ground.timing import Duration, Time
from pyros1.msgs import Message, from_definition
from pyros1.msgs.array_views import memoryview_view
from pyros1.msgs.base import nested_classes
from pyros1.msgs.generator import MAX_INLINE_VALUES

SEPARATOR = "=" * 80
ALL = f"""bool b
int8 i8
uint64 u64
float32 f
string s
time t
duration d
uint8[] bytes
uint8[3] three
char[] chars
byte[] signed
float64[] doubles
bool[] bools
bool[2] two_bools
int16[2] shorts
string[] strings
string[2] two_strings
time[] times
duration[1] one
Inner inner
Inner[] inners
Inner[2] two
Point point
Point[] points
Point[2] corners
Empty empty
Empty[2] empties
Empty[] any
int32[0] none
{SEPARATOR}
MSG: p/Inner
string name
Point[] path
{SEPARATOR}
MSG: p/Point
float64 x
int8 y
{SEPARATOR}
MSG: p/Empty
"""
All: Any = from_definition("p/All", ALL)


def make(text: str) -> Any:
    return from_definition("p/T", text)


def body(message: Message) -> bytes:
    frame = codec.encode_frame(message)
    joined = frame if isinstance(frame, bytes) else b"".join(frame)
    data = codec.encode(message)
    assert joined == struct.pack("<I", len(data)) + data
    return data


def roundtrip(message: Any) -> Any:
    data = body(message)
    return codec.decode(type(message), data, 0, len(data))


def test_wire_form() -> None:
    cls = make("uint8 a\nint16 b\nstring s\ntime t\nfloat64[] d\nuint8[] u\nstring[] l\nbool c")
    message = cls(1, -2, "é", Time(3, 4), (0.5,), b"xy", ["a", "bc"], True)
    expected = struct.pack("<BhI", 1, -2, 2) + b"\xc3\xa9" + struct.pack("<III", 3, 4, 1) + struct.pack("<d", 0.5)
    expected += b"\2\0\0\0xy" + b"\2\0\0\0" + b"\1\0\0\0a" + b"\2\0\0\0bc" + b"\1"
    assert body(message) == expected
    assert roundtrip(message) == message


def test_fixed_size() -> None:
    fixed = make("float64 a\nint8[3] b\ntime t\nuint8[2] c")
    assert len(body(fixed())) == 21
    with pytest.raises(DeserializationError):
        codec.decode(fixed, bytes(22), 0, 18)
    assert codec.decode(fixed, bytes(22), 0, 22) == codec.decode(fixed, bytes(21), 0, 21)
    assert body(make("")()) == b""


@pytest.mark.slow
@settings(max_examples=150)
@given(messages(All))
def test_values_round_trip_in_every_kind_of_buffer(message: Any) -> None:
    data = body(message)
    padded = b"abc" + data + b"d" * 40
    assert codec.decode(All, data, 0, len(data)) == message
    assert codec.decode(All, padded, 3, 3 + len(data)) == message
    for buffer in (data, bytearray(padded[3:]), memoryview(padded)[3:]):
        assert All().deserialize(buffer) == message
    decoded, end = codec.read(All, padded, 3, len(padded))
    assert decoded == message and end == 3 + len(data)
    assert body(decoded) == data


@pytest.mark.slow
@settings(max_examples=60)
@given(messages(All), st.data())
def test_cut_anywhere_is_an_error_and_bytes_behind_are_ignored(message: Any, data: st.DataObject) -> None:
    encoded = body(message)
    cut = data.draw(st.integers(0, len(encoded) - 1))
    for buffer in (encoded[:cut], encoded):  # the bytes may lie in the buffer: what counts is the end given
        with pytest.raises(DeserializationError, match=r"cannot decode p/All at byte \d+: .") as caught:
            codec.decode(All, buffer, 0, cut)
        assert 0 <= caught.value.offset <= cut
    behind = data.draw(st.binary(min_size=1, max_size=9))
    padded, whole, longer = b"_" + encoded + behind + b"next", 1 + len(encoded), 1 + len(encoded) + len(behind)
    for decode, arguments in ((codec.decode, ()), (codec.decode_arrays, (memoryview_view,))):
        assert body(decode(All, padded, 1, longer, *arguments)) == encoded
        assert body(decode(All, padded, 1, whole, *arguments, exact=True)) == encoded
        with pytest.raises(LengthError) as odd:
            decode(All, padded, 1, longer, *arguments, exact=True)
        assert odd.value.surplus == len(behind)


@settings(max_examples=300)
@given(st.binary(max_size=300), st.integers(0, 20))
def test_any_bytes_give_a_value_or_the_documented_error(data: bytes, start: int) -> None:
    for cls in (All, STRINGS, NESTED):
        try:
            value = codec.decode(cls, data, min(start, len(data)), len(data))
        except DeserializationError as error:
            assert error.type_name == cls._type
        else:
            body(value)


STRINGS: Any = make("string[] a\nuint16[] b")
NESTED: Any = make(f"A[] a\nstring s\n{SEPARATOR}\nMSG: p/A\nB[] b\nuint8 c\n{SEPARATOR}\nMSG: p/B\nstring s\nbool[] f")


@pytest.mark.slow
@settings(max_examples=100)
@given(messages(All), st.data())
def test_one_byte_changed_gives_a_value_or_the_documented_error(message: Any, data: st.DataObject) -> None:
    encoded = bytearray(body(message))
    encoded[data.draw(st.integers(0, len(encoded) - 1))] = data.draw(st.integers(0, 255))
    with contextlib.suppress(DeserializationError):
        codec.decode(All, encoded, 0, len(encoded))


@pytest.mark.parametrize(
    "element", ["uint8", "int8", "bool", "float64", "string", "time", "Empty", "Var", "Fixed", "Nothing"]
)
def test_nothing_large_is_allocated_on_a_lie(element: str) -> None:
    parts = ["MSG: p/Empty\n", "MSG: p/Var\nstring s\n", "MSG: p/Fixed\nint8 x\n", "MSG: p/Nothing\nEmpty a\n"]
    cls = make(f"{element}[] x\n" + "".join(f"{SEPARATOR}\n{part}" for part in parts))
    tracemalloc.start()
    try:
        for data in (b"\xff\xff\xff\xff", b"\xff\xff\xff\x7f" + bytes(1000)):
            if element == "uint8":  # cut off, as far as one can say
                assert codec.decode(cls, data, 0, len(data)).x == data[4:]
                continue
            with pytest.raises(DeserializationError, match=r"field x "):
                codec.decode(cls, data, 0, len(data))
        assert tracemalloc.get_traced_memory()[1] < 1 << 20
    finally:
        tracemalloc.stop()


def test_g19_types_after_decoding() -> None:
    text = (
        "uint8[] u\nchar[] c\nbyte[] b\nint8[2] i\nfloat32[] f\nbool[] l\nstring[] s\ntime[] t\nuint8[1] v\nbool[1] w"
    )
    message = roundtrip(make(text)(b"a", [1], [1], [1, 2], [1.0], [True], ["x"], [Time(1)], b"b", [True]))
    values = [getattr(message, name) for name in message.__slots__]
    assert values == [b"a", b"\1", (1,), (1, 2), (1.0,), [True], ["x"], [Time(1)], b"b", [True]]
    assert [type(value) for value in values] == [bytes, bytes, tuple, tuple, tuple, list, list, list, bytes, list]


def test_bool_is_any_byte_and_encodes_as_given() -> None:
    cls = make("bool a\nbool[] b")
    message = codec.decode(cls, b"\x05\x02\0\0\0\0\x09", 0, 7)
    assert (message.a, message.b) == (True, [False, True])
    assert body(cls(1, [True, 0])) == b"\1\2\0\0\0\1\0"
    assert body(cls(1, range(2))) == b"\1\2\0\0\0\0\1"


def test_times_of_the_whole_message_are_normalised_and_those_of_its_parts_are_as_received() -> None:
    separator = "\n" + "=" * 80 + "\nMSG: p/"
    pair, many = f"{separator}Pair\ntime t\nduration d", f"{separator}Many\nPair[1] p\ntime t"
    cls = make(f"time t\nduration d\ntime[] ts\nPair p\nPair[1] fixed\nMany[1] many{pair}{many}")
    one = struct.pack("<IIii", 1, 2_000_000_000, 1, -1)
    data = one + struct.pack("<III", 1, 1, 1_500_000_000) + 3 * one + struct.pack("<II", 1, 4_000_000_000)
    raw = codec.decode(cls, data, 0, len(data))
    raw.t.secs, raw.t.nsecs, raw.d.secs, raw.d.nsecs = 1, 2_000_000_000, 1, -1
    whole = cls, data, 0, len(data)
    for received in (codec.decode(*whole), codec.decode_arrays(*whole, memoryview_view), codec.copy(raw)):
        assert (received.t, received.d) == (Time(3, 0), Duration(0, 999_999_999))
        parts = [*received.ts, received.p.t, received.fixed[0].t, received.many[0].p[0].t, received.many[0].t]
        assert [(time.secs, time.nsecs) for time in parts] == [
            (1, 1_500_000_000),
            *3 * [(1, 2_000_000_000)],
            (1, 4_000_000_000),
        ]
        durations = [received.p.d, received.fixed[0].d, received.many[0].p[0].d]
        assert [(duration.secs, duration.nsecs) for duration in durations] == 3 * [(1, -1)]
        assert body(received)[28:] == data[28:]
    with pytest.raises(DeserializationError):
        codec.decode(cls, data[:-1], 0, len(data) - 1)


def test_g22_bytes_from_anything_that_holds_bytes() -> None:
    cls = make("uint8[] u\nuint8[3] v")
    for value in (b"abc", bytearray(b"abc"), memoryview(b"abc"), [97, 98, 99], (97, 98, 99)):
        assert body(cls(value, value)) == b"\3\0\0\0abcabc"
    assert body(cls(b"", b"a")) == b"\0\0\0\0a\0\0"  # as stock: padded


def test_numbers_from_an_array_object_are_not_converted_one_by_one() -> None:
    import array

    cls = make("float64[] x\nint16[] y")
    numbers = array.array("d", range(1000))
    assert body(cls(numbers, array.array("h", [1]))) == body(cls(tuple(numbers), [1]))
    assert body(cls(array.array("f", [1.5] * 500), [])) == body(
        cls((1.5,) * 500, [])
    )  # another format: element by element


class NotOneNumber:
    """As numpy's arrays, which have the method, too."""

    def __index__(self) -> int:
        raise TypeError("only integer scalar arrays can be converted to a scalar index")


@pytest.mark.parametrize(
    ("text", "value", "reason"),
    [
        ("uint8 x", 256, "field x exceeds specified width [uint8]"),
        ("int8 x", -129, "field x exceeds specified width [int8]"),
        ("uint64 x", 2**64, "field x exceeds specified width [uint64]"),
        ("int32 x", 1.5, "field x must be an integer type"),
        ("int32 x", "a", "field x must be an integer type"),
        ("int32 x", NotOneNumber(), "field x must be an integer type"),
        ("uint8 x", NotOneNumber(), "field x must be unsigned integer type"),
        ("char x", "a", "field x must be unsigned integer type"),
        ("uint16 x", -1, "field x must be unsigned integer type"),
        ("float64 x", "a", "field x must be float type"),
        ("float32 x", 1e300, "field x exceeds specified width [float32]"),
        ("float64 x", 10**400, "field x exceeds specified width [float64]"),
        ("bool x", "a", "field x is not a bool"),
        ("string x", 5, "field x must be of type bytes or an ascii string"),
        ("string x", b"ab", "field x must be of type bytes or an ascii string"),
        ("string x", "\ud800", "field x cannot be written as UTF-8"),
        ("uint8[] x", [1, 300], "field x[] exceeds specified width [uint8]"),
        ("uint8[] x", 5, "field x must be a list or tuple type"),
        ("uint8[] x", "abc", "field x must be a list or tuple type. Only uint8[] can be a string"),
        ("uint8[4] x", b"12345", "field x has 5 bytes, uint8[4] takes 4"),
        ("uint8[4] x", [1, 2], "field x has 2 elements, uint8[4] takes 4"),
        ("int32[2] x", [1, 2, 3], "field x has 3 elements, int32[2] takes 2"),
        ("int32[2] x", [1, 2.5], "field x[] must be an integer type"),
        ("int32[] x", 5, "field x must be a list or tuple type"),
        ("int32[] x", [1, None], "field x[] must be an integer type"),
        ("string[] x", ["a", 5], "field x[] must be of type bytes or an ascii string"),
        ("bool[2] x", [True], "field x has 1 elements, bool[2] takes 2"),
        ("string[2] x", ["a"], "field x has 1 elements, string[2] takes 2"),
        ("bool[] x", [True, 300], "field x[] is not a bool"),
        ("time x", 5, "field x must be a time, not int 5"),
        ("duration x", Duration(2**33), "field x exceeds specified width [duration]"),
        ("time[] x", [1], "field x[] must be a time, not int 1"),
        ("P x", 5, "field x must be of type p/P, but has no field [v]: int 5"),
        ("P[] x", [5], "field x[] must be of type p/P, but has no field [v]: int 5"),
        ("P[] x", 5, "field x must be a list or tuple type"),
    ],
)
def test_g21_wrong_values_name_the_field(text: str, value: object, reason: str) -> None:
    message = make(f"{text}\n{SEPARATOR}\nMSG: p/P\nint32 v")()
    message.x = value
    for encode in (codec.encode_frame, codec.encode, lambda m: m.serialize(io.BytesIO())):
        with pytest.raises(SerializationError) as caught:
            encode(message)
        assert str(caught.value).startswith(reason)


def test_g21_nested_fields_by_path() -> None:
    cls = make(f"A[] a\n{SEPARATOR}\nMSG: p/A\nB b\n{SEPARATOR}\nMSG: p/B\nint32 v")
    inner = nested_classes(cls)["p/A"]
    bad: Any = inner()
    bad.b.v = "x"
    with pytest.raises(SerializationError, match=r"^field a\[\]\.b\.v must be an integer type, not str 'x'$"):
        codec.encode(cls([inner(), bad]))


def test_large_bytes_are_not_copied() -> None:
    cls = make("int8 a\nuint8[] x\nstring s\nfloat64[] y")
    data = bytes(50_000)
    frame = codec.encode_frame(cls(1, data, "end", [1.0]))
    assert isinstance(frame, list) and frame[1] is data and len(frame) == 3
    assert isinstance(codec.encode_frame(cls(1, b"small", "end", [])), bytes)
    mutable = bytearray(50_000)
    frame = codec.encode_frame(cls(1, mutable, "", []))
    mutable[0] = 1
    assert b"".join(frame)[9] == 0  # what can change is copied
    assert codec.decode(cls, b"".join(frame)[4:], 0, len(b"".join(frame)) - 4).x == bytes(50_000)


@pytest.mark.parametrize("first", ["Point[4] corners", "time[2] t", "duration[1] t", "Inner[2] inners", "string[2] s"])
def test_a_fixed_array_as_the_first_field(first: str) -> None:
    cls = make(f"{first}\n{SEPARATOR}\nMSG: p/Point\nfloat64 x\n{SEPARATOR}\nMSG: p/Inner\nstring s")
    assert roundtrip(cls()) == cls()


@pytest.mark.parametrize("kind", ["time", "duration", "Point", "string"])
def test_an_array_of_messages_that_hold_arrays(kind: str) -> None:
    cls = make(f"Inner[] f\n{SEPARATOR}\nMSG: p/Inner\n{kind}[] t\n{SEPARATOR}\nMSG: p/Point\nfloat64 x")
    inner = nested_classes(cls)["p/Inner"]
    values = {"time": Time(1), "duration": Duration(2), "string": "s"}
    value: Any = values.get(kind) or nested_classes(inner)["p/Point"](3.0)  # type: ignore[call-arg]
    message = cls([inner([value]), inner([]), inner([value, value])])
    assert roundtrip(message) == message


def test_messages_with_more_fields_than_one_function_inlines() -> None:
    inner = "\n".join(f"int8 f{i}\nstring s{i}" for i in range(MAX_INLINE_VALUES // 4))
    text = f"A a\nA b\nA c\nint8 last\n{SEPARATOR}\nMSG: p/A\n{inner}\n"
    cls = make(text)
    message = cls()
    message.a.f0, message.b.s3, message.c.f7, message.last = 1, "x", 3, 4
    assert roundtrip(message) == message
    data = body(message)
    with pytest.raises(DeserializationError):
        codec.decode(cls, data, 0, len(data) - 1)
    message.c.f7 = "wrong"
    with pytest.raises(SerializationError, match=r"^field c\.f7 "):
        codec.encode(message)


def test_exponential_definitions_stay_small() -> None:
    levels = [f"{SEPARATOR}\nMSG: p/L{i}\n" + "\n".join(f"L{i + 1} f{j}" for j in range(10)) for i in range(12)]
    with pytest.raises(MessageError, match="too large"):
        make("L0 x\n" + "\n".join(levels) + f"\n{SEPARATOR}\nMSG: p/L12\nint8 x")


@pytest.mark.parametrize("text", ["float64[1000000000] x", "Empty[1000000] x", "Empty[100] x"])
def test_fixed_arrays_cannot_ask_for_all_memory(text: str) -> None:
    with pytest.raises(MessageError):
        make(f"{text}\n{SEPARATOR}\nMSG: p/Empty\n")


def test_g23_serialize_and_deserialize() -> None:
    cls = make("int8 a\nstring s")
    buffer = io.BytesIO()
    cls(5, "x").serialize(buffer)
    message = cls()
    assert message.deserialize(buffer.getvalue() + b"more") is message  # trailing bytes are ignored here
    assert (message.a, message.s) == (5, "x")
    for data in (b"", b"\5\1\0\0", b"\5"):
        with pytest.raises(DeserializationError, match="cannot decode p/T at byte"):
            cls().deserialize(data)


@pytest.mark.parametrize(("length", "cut"), [(56, False), (57, True)])
def test_long_values_are_cut_in_errors(length: int, cut: bool) -> None:
    """60 characters are shown, with the name of the type and quotation marks."""
    message = make("int32 x")()
    message.x = "a" * (length - 2)
    with pytest.raises(SerializationError) as caught:
        codec.encode(message)
    shown = str(caught.value).partition(", not ")[2]
    assert shown == (f"str '{'a' * 52}..." if cut else f"str '{'a' * 54}'")
