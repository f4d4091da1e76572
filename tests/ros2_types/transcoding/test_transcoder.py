"""Known answers, and what cannot be converted."""

from __future__ import annotations

import struct

import pytest
from rosbags_models import ros1_specs, ros2_types

from pyros1.ground.errors import DefinitionError, MessageError
from pyros1.msgs.spec import MessageSpec, parse_message
from pyros1.ros2_types.model import Field, FieldType, Length, MessageType
from pyros1.ros2_types.transcoding.transcoder import Transcoder

_TIME = MessageType("x/msg/Time", (Field("sec", FieldType("int32")), Field("nanosec", FieldType("uint32"))))
_FLOAT_TIME = MessageType(
    "x/msg/FloatTime", (Field("sec", FieldType("float32")), Field("nanosec", FieldType("uint32")))
)


def _transcoder(definition: str, *fields: tuple[str, FieldType], **nested: str) -> Transcoder:
    """Return a transcoder; ``nested`` has further ROS 1 types of the package."""
    texts = {"T": definition} | nested
    specs: dict[str, MessageSpec] = {f"x/{name}": parse_message(f"x/{name}", text) for name, text in texts.items()}
    root = MessageType("x/msg/T", tuple(Field(name, field_type) for name, field_type in fields))
    other = MessageType("x/msg/Two", (Field("b", FieldType("uint8")), Field("a", FieldType("float64"))))
    empty = MessageType("x/msg/Empty", ())
    return Transcoder("x/T", specs, "x/msg/T", {item.name: item for item in (root, _TIME, _FLOAT_TIME, other, empty)})


def _sequence(base: str, bound: int = 0, string_bound: int = 0) -> FieldType:
    return FieldType(base, Length.BOUNDED if bound else Length.UNBOUNDED, bound, string_bound)


def test_string() -> None:
    transcoder = _transcoder("string data", ("data", FieldType("string")))
    assert transcoder.to_cdr(b"\5\0\0\0hello") == b"\0\1\0\0\6\0\0\0hello\0"
    assert transcoder.from_cdr(b"\0\1\0\0\6\0\0\0hello\0") == b"\5\0\0\0hello"
    assert transcoder.from_cdr(b"\0\0\0\0\0\0\0\6hello\0") == b"\5\0\0\0hello"
    assert transcoder.from_cdr(b"\0\1\0\0\0\0\0\0") == b"\0\0\0\0"


def test_joint_state_of_rclpy() -> None:
    cdr = bytes.fromhex(
        "000100000000000000000000020000007800281402000000020000006100000003000000626300000000000001000000102cb50f"
        "000000000000f03f0000000020a12d14"
    )
    body = struct.pack("<IIII1sII1sI2sIIdI", 1, 0, 0, 1, b"x", 2, 1, b"a", 2, b"bc", 0, 1, 1.0, 0)
    transcoder = Transcoder(
        "sensor_msgs/JointState", ros1_specs("sensor_msgs/JointState"), "sensor_msgs/msg/JointState", ros2_types()
    )
    assert transcoder.from_cdr(cdr) == body
    clean = cdr.replace(b"x\0\x28\x14", b"x\0\0\0").replace(bytes.fromhex("102cb50f"), bytes(4))[:-4]
    assert transcoder.to_cdr(body) == clean


def test_wstring_of_rclpy() -> None:
    transcoder = _transcoder("string data", ("data", FieldType("wstring")))
    cdr = bytes.fromhex("000100000400000061000000e90000003dd8000000de0000")
    text = "aé😀".encode()
    assert transcoder.from_cdr(cdr) == struct.pack("<I", len(text)) + text
    assert transcoder.to_cdr(struct.pack("<I", len(text)) + text) == cdr
    assert transcoder.to_cdr(b"\1\0\0\0\xff") == b"\0\1\0\0\1\0\0\0\xfd\xff\0\0"
    assert transcoder.from_cdr(b"\0\1\0\0\1\0\0\0\0\xd8\0\0") == b"\3\0\0\0\xef\xbf\xbd"
    with pytest.raises(MessageError, match="not UTF-16"):
        transcoder.from_cdr(b"\0\1\0\0\1\0\0\0\0\0\1\0")


def test_strings_that_are_not_utf8_are_passed() -> None:
    transcoder = _transcoder("string[] data", ("data", _sequence("string")))
    body = b"\2\0\0\0\1\0\0\0\xff\0\0\0\0"
    cdr = b"\0\1\0\0\2\0\0\0\2\0\0\0\xff\0\0\0\1\0\0\0\0"
    assert transcoder.to_cdr(body) == cdr
    assert transcoder.from_cdr(cdr) == body
    assert transcoder.from_cdr(cdr[:-5] + bytes(4)) == body  # the second string without its zero byte


def test_empty_message() -> None:
    transcoder = _transcoder("")
    assert transcoder.to_cdr(b"") == b"\0\1\0\0\0"
    assert transcoder.from_cdr(b"\0\1\0\0\0") == b""
    assert transcoder.only_ros2 == []


def test_arrays_of_empty_messages_are_limited() -> None:
    transcoder = _transcoder("Empty[] data", ("data", _sequence("x/msg/Empty")), Empty="")
    assert transcoder.to_cdr(b"\3\0\0\0") == b"\0\1\0\0\3\0\0\0\0\0\0"
    assert transcoder.from_cdr(b"\0\1\0\0\3\0\0\0\0\0\0") == b"\3\0\0\0"
    for body in (b"\x11\0\0\0", b"\xff\xff\xff\xff"):
        with pytest.raises(MessageError, match="too many elements"):
            transcoder.to_cdr(body)


def test_fields_of_one_side() -> None:
    transcoder = _transcoder(
        "uint8 a\nstring dropped\nTwo nested\nuint8 z",
        ("new", FieldType("float64")),
        ("a", FieldType("uint8")),
        ("text", FieldType("string")),
        ("nested", FieldType("x/msg/Two")),
        ("z", FieldType("uint8")),
        ("times", FieldType("x/msg/Time", Length.FIXED, 2)),
        Two="uint8 b\nint16 c",
    )
    assert transcoder.only_ros1 == ["dropped", "nested.c"]
    assert transcoder.only_ros2 == ["nested.a", "new", "text", "times"]
    body = b"\1" + b"\2\0\0\0ab" + b"\3\4\0" + b"\5"
    cdr = bytes(8) + b"\1\0\0\0" + b"\1\0\0\0\0" + b"\3" + bytes(6) + bytes(8) + b"\5" + bytes(3) + bytes(16)
    assert transcoder.to_cdr(body) == b"\0\1\0\0" + cdr
    body = b"\1" + b"\0\0\0\0" + b"\3\0\0" + b"\5"
    assert transcoder.from_cdr(b"\0\1\0\0" + cdr) == body


def test_capitals_of_ros1_are_small_in_ros2() -> None:
    transcoder = _transcoder("uint8 K\nuint8 k\nuint8 D", ("k", FieldType("uint8")), ("d", FieldType("uint8")))
    assert transcoder.only_ros1 == ["K"]
    assert transcoder.to_cdr(b"\1\2\3") == b"\0\1\0\0\2\3"


def test_sequence_numbers_are_counted() -> None:
    name = "std_msgs/Header"
    transcoder = Transcoder(name, ros1_specs(name), "std_msgs/msg/Header", ros2_types())
    cdr = transcoder.to_cdr(struct.pack("<IIiI1s", 7, 0x80000001, -2, 1, b"f"))
    assert cdr == b"\0\1\0\0" + struct.pack("<IiI2s", 0x80000001, -2, 2, b"f")
    for seq in (1, 2, 3):
        assert transcoder.from_cdr(cdr) == struct.pack("<IIiI1s", seq, 0x80000001, -2, 1, b"f")
    assert transcoder.only_ros1 == []
    name = "std_msgs/msg/Header"
    pair = MessageType("x/msg/P", tuple(Field(field, FieldType(name)) for field in "ab"))
    specs = {**ros1_specs("std_msgs/Header"), "x/P": parse_message("x/P", "Header a\nHeader b")}
    transcoder = Transcoder("x/P", specs, "x/msg/P", {**ros2_types(), pair.name: pair})
    for seq in (1, 2):
        body = transcoder.from_cdr(b"\0\1\0\0" + struct.pack("<III1s3xIII1s", 0, 0, 1, b"", 0, 0, 1, b""))
        assert body == struct.pack("<IIIIIIII", seq, 0, 0, 0, seq, 0, 0, 0)


def test_bounds() -> None:
    transcoder = _transcoder(
        "uint8[] some\nstring text\nstring[] texts\nstring wide",
        ("some", _sequence("uint8", 2)),
        ("text", FieldType("string", string_bound=3)),
        ("texts", _sequence("string", 0, 1)),
        ("wide", FieldType("wstring", string_bound=1)),
    )

    def body(some: bytes = b"ab", text: bytes = b"abc", item: bytes = b"a", wide: str = "ä") -> bytes:
        encoded = wide.encode()
        texts = struct.pack("<II", 1, len(item)) + item + struct.pack("<I", len(encoded)) + encoded
        return struct.pack("<I", len(some)) + some + struct.pack("<I", len(text)) + text + texts

    transcoder.to_cdr(body())
    for message, problem in (
        (body(some=b"abc"), "some has more than 2 elements"),
        (body(text=b"abcd"), "text is longer than 3"),
        (body(item=b"ab"), "texts is longer than 1"),
        (body(wide="ab"), "wide is longer than 1"),
    ):
        with pytest.raises(MessageError, match=problem):
            transcoder.to_cdr(message)
    # ROS 1 has no bounds.
    cdr = b"\0\1\0\0\3\0\0\0abc\0\6\0\0\0abcde" + bytes(11)
    assert transcoder.from_cdr(cdr) == b"\3\0\0\0abc\5\0\0\0abcde" + bytes(8)


def test_fixed_array_from_sequence() -> None:
    transcoder = _transcoder(
        "uint16[2] a\nuint16[] b", ("a", _sequence("uint16")), ("b", FieldType("uint16", Length.FIXED, 2))
    )
    body, cdr = b"\1\0\2\0\2\0\0\0\3\0\4\0", b"\0\1\0\0\2\0\0\0\1\0\2\0\3\0\4\0"
    assert transcoder.to_cdr(body) == cdr
    assert transcoder.from_cdr(cdr) == body
    with pytest.raises(MessageError, match="b does not have 2 elements"):
        transcoder.to_cdr(b"\1\0\2\0\1\0\0\0\3\0")
    with pytest.raises(MessageError, match="a does not have 2 elements"):
        transcoder.from_cdr(b"\0\1\0\0\1\0\0\0\1\0\3\0\4\0")


@pytest.mark.parametrize(
    ("definition", "field_type"),
    [
        ("string a", FieldType("int32")),
        ("int32 a", FieldType("string")),
        ("int32 a", FieldType("uint32")),
        ("bool a", FieldType("uint8")),
        ("int32 a", FieldType("x/msg/Two")),
        ("Two a", FieldType("float64")),
        ("Two a", FieldType("string")),
        ("time a", FieldType("x/msg/Two")),
        ("time a", FieldType("x/msg/FloatTime")),
        ("time a", FieldType("uint64")),
        ("int8 a", _sequence("int8")),
        ("int8[] a", FieldType("int8")),
        ("int8[2] a", FieldType("int8", Length.FIXED, 3)),
        ("int8[3] a", _sequence("int8", 2)),
    ],
)
def test_types_that_do_not_convert(definition: str, field_type: FieldType) -> None:
    with pytest.raises(DefinitionError) as caught:
        _transcoder(definition, ("a", field_type), Two="uint8 b\nfloat64 a")
    for word in ("cannot convert x/T and x/msg/T", ": a: ", definition.split(maxsplit=1)[0], field_type.base):
        assert word in str(caught.value)


def test_definitions_that_are_too_large() -> None:
    huge = FieldType("float64", Length.FIXED, 1 << 40)
    for fields in ([("a", huge)], [("a", FieldType("string", Length.FIXED, 1 << 40))]):
        with pytest.raises(DefinitionError, match="too large"):
            _transcoder("", *fields)
    with pytest.raises(DefinitionError, match="contains itself"):
        _transcoder("T a", ("b", FieldType("uint8")))
    with pytest.raises(DefinitionError, match="x/Missing is missing"):
        _transcoder("Missing a")
    with pytest.raises(DefinitionError, match="x/msg/Missing is missing"):
        _transcoder("", ("a", FieldType("x/msg/Missing")))
    layers = {f"L{number}": f"L{number + 1} a\nL{number + 1} b" for number in range(40)} | {"L40": "uint8 a"}
    with pytest.raises(DefinitionError, match="more than 5000 fields"):
        _transcoder("L0 a", **layers)
    layers = {f"L{number}": f"L{number + 1}[] a" for number in range(20)} | {"L20": "string a"}
    with pytest.raises(DefinitionError, match="arrays in arrays"):
        _transcoder("L0 a", **layers)


def test_names_of_fields_are_not_code() -> None:
    name = "a'); raise SystemExit #\n"
    spec = parse_message("x/T", "uint8[] b")
    spec = spec._replace(fields=(spec.fields[0]._replace(name=name),))
    types = {"x/msg/T": MessageType("x/msg/T", (Field(name, _sequence("uint8", 1)),))}
    transcoder = Transcoder("x/T", {"x/T": spec}, "x/msg/T", types)
    with pytest.raises(MessageError, match="raise SystemExit"):
        transcoder.to_cdr(b"\2\0\0\0ab")


@pytest.mark.parametrize("data", [b"", b"\0\1", b"\0\1\0", b"\0\2\0\0ab", b"\0\7\0\0ab", b"\1\1\0\0ab"])
def test_wrong_headers(data: bytes) -> None:
    with pytest.raises(MessageError, match="header"):
        _transcoder("uint8 a", ("a", FieldType("uint8"))).from_cdr(data)


def test_lengths_that_lie() -> None:
    transcoder = _transcoder(
        "float64[] a\nTwo[] b", ("a", _sequence("float64")), ("b", _sequence("x/msg/Two")), Two="uint8 b\nfloat64 a"
    )
    for convert, prefix in (
        (transcoder.to_cdr, b""),
        (transcoder.from_cdr, b"\0\1\0\0"),
        (transcoder.from_cdr, bytes(4)),
    ):
        for numbers in ((0xFFFFFFFF,), (0, 0xFFFFFFFF), (0, 0x7FFFFFFF, 0, 0, 0)):
            with pytest.raises(MessageError, match="cannot convert a x/"):
                convert(prefix + struct.pack(f"{'>' if prefix == bytes(4) else '<'}{len(numbers)}I", *numbers))


def test_large_arrays() -> None:
    transcoder = _transcoder("uint8 a\nfloat64[] b", ("a", FieldType("uint8")), ("b", _sequence("float64")))
    numbers = bytes(range(250)) * 80
    body = b"\1" + struct.pack("<I", 2500) + numbers
    cdr = b"\0\1\0\0\1\0\0\0" + struct.pack("<I", 2500) + numbers
    assert transcoder.to_cdr(bytes(body)) == transcoder.to_cdr(memoryview(bytearray(body))) == cdr
    assert transcoder.from_cdr(cdr) == transcoder.from_cdr(memoryview(cdr)) == body


def test_fixed_arrays_of_messages() -> None:
    for count in (2, 1000):
        fixed = FieldType("x/msg/Two", Length.FIXED, count)
        transcoder = _transcoder(
            f"uint8 a\nTwo[{count}] b\nuint8 c",
            ("a", FieldType("uint8")),
            ("b", fixed),
            ("c", FieldType("uint8")),
            Two="uint8 b\nfloat64 a",
        )
        body = b"\1" + struct.pack("<Bd", 2, 3.0) * count + b"\4"
        first = b"\1\2" + bytes(6) + struct.pack("<d", 3.0)
        cdr = b"\0\1\0\0" + first + struct.pack("<B7xd", 2, 3.0) * (count - 1) + b"\4"
        assert transcoder.to_cdr(body) == cdr
        assert transcoder.from_cdr(cdr) == body
        with pytest.raises(MessageError):
            transcoder.to_cdr(body[:-1])


def test_fixed_arrays_of_numbers_only_copied() -> None:
    fixed = FieldType("x/msg/Time", Length.FIXED, 1000)
    transcoder = _transcoder("Pair[1000] b", ("b", fixed), Pair="int32 sec\nuint32 nanosec")
    body = bytes(range(250)) * 32
    assert transcoder.to_cdr(body) == b"\0\1\0\0" + body
    assert transcoder.from_cdr(b"\0\1\0\0" + body) == body


def _check_elements(ros1_element: str, ros2_fields: list[tuple[str, str]], ros1_bytes: bytes, cdr: bytes) -> None:
    """Check the conversion of an array of three equal messages, followed by an uint8; ``cdr`` is what they become."""
    specs = {
        "x/T": parse_message("x/T", "E[] elements\nuint8 end"),
        "x/E": parse_message("x/E", ros1_element),
    }
    types = {
        "x/msg/T": MessageType("x/msg/T", (Field("elements", _sequence("x/msg/E")), Field("end", FieldType("uint8")))),
        "x/msg/E": MessageType("x/msg/E", tuple(Field(name, FieldType(base)) for name, base in ros2_fields)),
    }
    transcoder = Transcoder("x/T", specs, "x/msg/T", types)
    body = b"\3\0\0\0" + ros1_bytes * 3 + b"\xee"
    assert transcoder.to_cdr(body) == b"\0\1\0\0\3\0\0\0" + cdr + b"\xee"
    if not transcoder.only_ros1:
        assert transcoder.from_cdr(b"\0\1\0\0\3\0\0\0" + cdr + b"\xee") == body


def test_elements_that_need_padding_only_between_them() -> None:
    element = b"\1\2\3\4\5\6"
    cdr = element + b"\0\0" + element + b"\0\0" + element
    _check_elements("uint32 a\nuint16 b", [("a", "uint32"), ("b", "uint16")], element, cdr)


def test_elements_with_another_order() -> None:
    _check_elements("uint8 a\nuint8 b", [("b", "uint8"), ("a", "uint8")], b"\1\2", b"\2\1" * 3)


def test_elements_without_a_string_of_ros1() -> None:
    element = b"12345678\1\0\0\0x\5"
    cdr = b"\0\0\0\0" + b"12345678\5\0\0\0\0\0\0\0" * 2 + b"12345678\5"
    _check_elements("float64 a\nstring s\nuint8 b", [("a", "float64"), ("b", "uint8")], element, cdr)


def test_too_many_elements_are_refused_before_the_first() -> None:
    transcoder = _transcoder("Two[] b", ("b", _sequence("x/msg/Two")), Two="uint8 b\nfloat64 a")
    with pytest.raises(MessageError, match="too many elements"):
        transcoder.to_cdr(b"\2\0\0\0" + bytes(17))
    with pytest.raises(MessageError, match="too many elements"):
        transcoder.from_cdr(b"\0\1\0\0\2\0\0\0" + bytes(17))


def test_elements_that_are_much_larger_on_the_other_side_do_not_multiply_the_memory() -> None:
    large = FieldType("float64", Length.FIXED, 2000)
    types = {
        "x/msg/Root": MessageType("", (Field("b", _sequence("x/msg/Two")),)),
        "x/msg/Two": MessageType("", (Field("c", _sequence("x/msg/One")),)),
        "x/msg/One": MessageType("", (Field("a", FieldType("uint8")), Field("d", large))),
    }
    texts = {"x/Root": "Two[] b", "x/Two": "One[] c", "x/One": "uint8 a"}
    transcoder = Transcoder(
        "x/Root", {name: parse_message(name, text) for name, text in texts.items()}, "x/msg/Root", types
    )
    few = b"\1\0\0\0" + b"\x0a\0\0\0" + bytes(10)
    assert len(transcoder.to_cdr(few)) > 160_000
    many = b"\xe8\3\0\0" + (b"\x0a\0\0\0" + bytes(10)) * 1000
    with pytest.raises(MessageError, match="much larger"):
        transcoder.to_cdr(many)


def test_fixed_arrays_in_fixed_arrays_do_not_multiply_the_code() -> None:
    depth = 4
    specs = {f"x/L{level}": parse_message(f"x/L{level}", f"L{level + 1}[9] a") for level in range(depth)}
    specs[f"x/L{depth}"] = parse_message(f"x/L{depth}", "string a")
    types = {
        f"x/msg/L{level}": MessageType("", (Field("a", FieldType(f"x/msg/L{level + 1}", Length.FIXED, 9)),))
        for level in range(depth)
    } | {f"x/msg/L{depth}": MessageType("", (Field("a", FieldType("string")),))}
    transcoder = Transcoder("x/L0", specs, "x/msg/L0", types)
    body = bytes(4 * 9**depth)
    assert transcoder.from_cdr(transcoder.to_cdr(body)) == body
