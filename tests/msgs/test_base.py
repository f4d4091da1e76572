"""The class interface that programs know from genpy (G10, G16-G18, G24)."""

from __future__ import annotations

import copy
import io
import pickle
import pydoc
import struct
from typing import Any

import codec
import pytest

from pyros1.ground.errors import DefinitionError, DeserializationError
from pyros1.ground.timing import Duration, Time
from pyros1.msgs import AnyMsg, Message, from_definition, load_message, load_service
from pyros1.msgs.base import message_class
from pyros1.msgs.generator import MAX_FIELDS_PER_FUNCTION

from ..bodies import decode, encode, encode_frame

SEPARATOR = "=" * 80


def make(text: str) -> Any:
    return from_definition("p/T", text)


def test_g16_attributes() -> None:
    cls: Any = load_message("std_msgs/Header")
    assert (cls._type, cls._md5sum) == ("std_msgs/Header", "2176decaecbce78abc3b96ef049fabed")
    assert cls.__slots__ == ["seq", "stamp", "frame_id"]
    assert cls._slot_types == ["uint32", "time", "string"]
    assert not cls._has_header
    assert load_message("geometry_msgs/PoseStamped")._has_header
    assert cls()._get_types() == cls._slot_types


def test_g17_constructor() -> None:
    cls = make("int32 a\nstring b")
    assert (cls().a, cls().b) == (0, "")
    assert (cls(1, "x").a, cls(1, "x").b) == (1, "x")
    assert (cls(b="x").a, cls(b="x").b) == (0, "x")
    assert (cls(None, "x").a, cls(a=None).b) == (0, "")
    with pytest.raises(TypeError, match=r"Invalid number of arguments, args should be \['a', 'b'\] args are\(1,\)"):
        cls(1)
    with pytest.raises(TypeError, match="may only use args OR keywords, not both"):
        cls(1, b=2)
    with pytest.raises(AttributeError, match="zz is not an attribute of T"):
        cls(zz=1)


def test_g18_defaults_and_that_they_are_not_shared() -> None:
    text = "bool b\nfloat32 f\nuint8[] u\nuint8[2] v\nchar[] c\nint8[] i\nint8[2] j\nstring[2] s\ntime t\nduration d\n"
    cls = make(f"{text}N n\nN[2] m\ntime[1] ts\nN[] e\n{SEPARATOR}\nMSG: p/N\nint8[] x")
    message = cls()
    values = [getattr(message, name) for name in message.__slots__]
    nested = message.n
    start = [False, 0.0, b"", b"\0\0", b"", [], [0, 0], ["", ""], Time(), Duration(), nested, [nested, nested]]
    assert values == [*start, [Time()], []]
    assert [type(value) for value in values[:5]] == [bool, float, bytes, bytes, bytes]
    other = cls()
    for name in ("i", "t", "d", "n", "m", "e"):
        assert getattr(message, name) is not getattr(other, name)
    assert message.m[0] is not message.m[1]
    assert cls(b=True).n is not cls(b=True).n


def test_g10_reserved_words() -> None:
    cls = make("int8 from\nstring class\nint8 self\nint8 None=3\nint8 print")
    assert cls.__slots__ == ["from_", "class_", "self_", "print"]
    assert cls.None_ == 3
    message = cls(1, "c", 2, 4)
    assert decode(cls, encode(message)) == message
    assert cls(from_=1).from_ == 1
    assert cls._full_text.startswith("int8 from\n")


def test_constants_are_class_attributes() -> None:
    assert load_message("sensor_msgs/PointField").FLOAT32 == 7  # type: ignore[attr-defined]  # made from the definition
    with pytest.raises(DefinitionError, match="same name"):
        make("int8 X=1\nint8 X")


def test_full_text_of_classes_messages_and_classes_made_of_them() -> None:
    cls = make("int8 x  # why")
    derived = type("Derived", (cls,), {})
    assert derived._full_text == derived()._full_text == cls()._full_text == cls._full_text == "int8 x  # why"
    header = load_message("std_msgs/Header")
    assert header()._full_text == header._full_text and "uint32 seq" in header._full_text
    assert not hasattr(Message, "_full_text")
    assert "_full_text" in pydoc.render_doc(Message)


def test_two_fields_of_one_name_in_python_are_refused() -> None:
    with pytest.raises(DefinitionError, match=r"two fields have the name \[from_\]"):
        make("int8 from\nint8 from_")


def test_the_constructor_of_a_message_with_many_fields() -> None:
    cls = make("\n".join(f"int8 f{i}" for i in range(1200)))
    assert cls(*range(1200)).f1199 == 1199
    message = cls(f7=1, f1100=None, f1101=2)
    assert (message.f7, message.f8, message.f1100, message.f1101) == (1, 0, 0, 2)
    with pytest.raises(AttributeError, match="nope"):
        cls(**{f"f{i}": i for i in range(60)}, nope=1)
    with pytest.raises(TypeError, match="Invalid number"):
        cls(*range(1199))


@pytest.mark.parametrize(
    "count",
    [
        MAX_FIELDS_PER_FUNCTION,
        MAX_FIELDS_PER_FUNCTION + 1,
        2 * MAX_FIELDS_PER_FUNCTION,
        2 * MAX_FIELDS_PER_FUNCTION + 1,
    ],
)
def test_no_field_is_lost_where_one_function_ends_and_the_next_begins(count: int) -> None:
    cls = make("\n".join(f"int16[] f{i}" for i in range(count)))
    assert cls() == cls(*[[]] * count)
    message = cls(*([i] for i in range(count)))
    assert codec.copy(message) == message
    body = codec.encode(message)
    assert body == b"".join(struct.pack("<Ih", 1, i) for i in range(count))
    assert codec.decode(cls, body, 0, len(body)) == message


def test_field_names_may_be_those_of_methods() -> None:
    cls = make("int8 serialize\nint8 data\nint8 m\nint8 buf\nint8 start\nint8 new\nint8 args\nint8 q")
    message = cls(*range(8))
    assert codec.decode(cls, codec.encode(message), 0, 8) == message


def test_g24_equality() -> None:
    cls, other = make("int8[] a\nstring b"), make("int8[] a\nstring b")
    assert cls([1, 2], "x") == cls((1, 2), "x")
    assert cls([1, 2], "x") != cls([1, 3], "x")
    assert cls([1], "x") != other([1], "x")  # another class, though of the same name
    assert cls() != "text"
    for odd in (None, 1, "ab", range(2)):
        message = cls([0, 1], "x")
        message.a = odd
        assert message != cls([0, 1], "x") and cls([0, 1], "x") != message
    with pytest.raises(TypeError):
        hash(cls())


def test_g24_copies_and_pickles() -> None:
    cls: Any = load_message("geometry_msgs/PoseStamped")
    message = cls()
    message.header.stamp, message.pose.position.x = Time(1, 2), 3.0
    for twin in (pickle.loads(pickle.dumps(message)), copy.deepcopy(message), copy.copy(message)):
        assert twin == message and type(twin) is cls
    message._connection_header = {"callerid": "/x"}
    assert message == copy.copy(message)


def test_a_message_that_an_earlier_version_pickled_is_read() -> None:
    message = make("int8 a\nstring b")()
    message.__setstate__((None, {"b": "text", "a": 3}))
    assert (message.a, message.b) == (3, "text")


def test_derived_classes_encode_as_their_base() -> None:
    cls = make("int8 a")

    class Mine(cls):  # type: ignore[misc,valid-type]  # made at run time
        pass

    assert Mine(5).a == 5
    assert encode(Mine(5)) == b"\5"
    assert decode(Mine, b"\5") == Mine(5)
    assert message_class(Mine) is cls
    assert Mine(5) == Mine(5)


def test_unknown_class_attributes_are_attribute_errors() -> None:
    assert not hasattr(make("int8 a"), "_other")


def test_the_docstring_is_the_definition() -> None:
    assert make("int8 a # of b\n").__doc__ == "int8 a # of b\n"
    assert make("").__doc__ == "Message type p/T, without fields."
    assert load_service("std_srvs/Empty").__doc__ == "---"


def test_help_describes_message_classes_also_once_they_have_been_encoded() -> None:
    cls = make("int8 a")
    encode(cls(5))
    assert "class T" in pydoc.render_doc(cls)


@pytest.mark.parametrize(
    "use",
    [encode, encode_frame, lambda message: message.serialize(io.BytesIO()), lambda message: message.decode(make(""))],
    ids=["body", "frame", "serialize", "decode"],
)
def test_any_message_that_has_no_bytes_yet(use: Any) -> None:
    # The drop-in rospy, if another test has imported it, makes this the error that its programs know.
    with pytest.raises(Exception, match=r"^(this AnyMsg has no bytes|AnyMsg is not initialized)"):
        use(AnyMsg())


def test_any_message() -> None:
    message = AnyMsg().deserialize(memoryview(b"\5"))
    assert message._buff == b"\5"
    assert encode(message) == b"\5"
    with pytest.raises(DefinitionError, match="contains no type"):
        message.decode()
    message._connection_header = {"type": "q/T", "message_definition": "int8 a", "callerid": "/n"}
    real: Any = message.decode()
    assert (real._type, real.a, real._connection_header["callerid"]) == ("q/T", 5, "/n")
    assert message.decode(make("int8 b")).b == 5  # type: ignore[attr-defined]  # made from the definition
    with pytest.raises(DeserializationError):
        message.decode(make("int16 b"))
