"""Arrays of messages as numpy arrays with named columns.

Feature: arrays of messages of fixed size, such as poses, as numpy arrays with named columns: received and sent without
    a loop
"""

from __future__ import annotations

from typing import Any

import codec
import pytest

from pyros1.ground.errors import SerializationError
from pyros1.msgs import from_definition, record_dtype
from pyros1.msgs.array_views import find_view
from pyros1.msgs.base import nested_classes
from pyros1.msgs.geometry_msgs.msg import Point, Pose, PoseArray, Quaternion

numpy = pytest.importorskip("numpy")
SEPARATOR = "=" * 80
POINT = [("x", "<f8"), ("y", "<f8"), ("z", "<f8")]
POSE = [("position", POINT), ("orientation", [*POINT, ("w", "<f8")])]
DEFINITION = f"""
Part[] parts
{SEPARATOR}
MSG: p/Part
bool good
time stamp
duration[2] ages
uint8[3] bytes
float32[2] numbers
Small[2] smalls
{SEPARATOR}
MSG: p/Small
int16 a
char b
"""


def poses(count: int = 3) -> Any:
    return PoseArray(poses=[Pose(Point(i, 2.0 * i, -1.0), Quaternion(0.0, 0.0, 0.5, i + 0.25)) for i in range(count)])


def decoded(cls: Any, body: bytes) -> Any:
    view = find_view("numpy")
    assert view is not None
    return codec.decode_arrays(cls, body, 0, len(body), view)


def test_columns_and_elements() -> None:
    body = codec.encode(poses())
    message = decoded(PoseArray, body)
    assert message.poses["position"]["y"].tolist() == [0.0, 2.0, 4.0]
    assert message.poses.orientation.w.tolist() == [0.25, 1.25, 2.25]
    assert [pose.position.x for pose in message.poses] == [0.0, 1.0, 2.0]
    assert len(decoded(PoseArray, codec.encode(poses(0))).poses) == 0
    with pytest.raises(ValueError, match="read-only"):
        message.poses["position"]["y"] = 1.0
    assert message.poses.base is not None  # not a copy
    assert codec.encode(message) == body


def test_all_kinds_of_fields() -> None:
    cls: Any = from_definition("p/T", DEFINITION)
    dtype = record_dtype(nested_classes(cls)["p/Part"])
    assert dtype.itemsize == 1 + 8 + 16 + 3 + 8 + 6
    parts = numpy.zeros(2, dtype)
    parts["good"] = True
    parts["stamp"]["secs"] = 7, 8
    parts["ages"]["nsecs"][1] = -1, -2
    parts["bytes"][1] = 1, 2, 3
    parts["numbers"][0] = 0.5, 0.25
    parts["smalls"]["a"][1] = -3, 4
    message = codec.decode(cls, codec.encode(cls(parts)), 0, len(codec.encode(cls(parts))))
    assert [part.stamp.secs for part in message.parts] == [7, 8] and message.parts[0].good is True
    assert [age.nsecs for age in message.parts[1].ages] == [-1, -2]
    assert message.parts[1].bytes == b"\1\2\3" and message.parts[0].numbers == (0.5, 0.25)
    assert [small.a for small in message.parts[1].smalls] == [-3, 4]
    assert codec.copy(cls(parts)) == message
    cls(parts)._check_types()


@pytest.mark.parametrize(
    "dtype",
    [POSE, numpy.dtype([("position", ">f8,>f8,>f8"), ("orientation", ">f8,>f8,>f8,>f8")]), "padded", "small"],
    ids=["packed", "big-endian, other names", "padded", "float32"],
)
def test_other_arrays_that_fit(dtype: Any) -> None:
    array = decoded(PoseArray, codec.encode(poses())).poses
    if dtype == "padded":
        padded = numpy.dtype({"names": ["position", "orientation"], "formats": [POINT, POSE[1][1]], "offsets": [8, 40]})
        other = array.astype(padded)
    elif dtype == "small":
        three = [(name, "<f4") for name in "xyz"]
        other = array.astype([("position", three), ("orientation", [*three, ("w", "<f4")])])
    elif dtype == POSE:
        other = numpy.repeat(numpy.array(array), 2)[::2]  # not contiguous
    else:
        with pytest.raises(SerializationError, match=r"field poses takes .*record_dtype\(Pose\), not"):
            codec.encode(PoseArray(poses=array.astype(dtype)))
        return
    assert codec.encode(PoseArray(poses=other)) == codec.encode(poses())
    assert codec.copy(PoseArray(poses=other)) == poses()


@pytest.mark.parametrize(
    ("value", "why"),
    [
        (numpy.zeros(3, POINT), r"field poses takes an array with the dtype record_dtype\(Pose\), not \[\('x'"),
        (numpy.zeros((2, 2), POSE), r"one dimension, not of shape \(2, 2\)"),
        (numpy.zeros((), POSE), r"field poses must be an array of one dimension, not of shape \(\)"),
        (numpy.array(5), r"field poses must be a list or tuple type, not ndarray array\(5\)"),
        (numpy.zeros(2, POSE[::-1]), r"record_dtype\(Pose\)"),
        (numpy.zeros(2, [("position", POINT), ("orientation", [*POINT, ("w", "c16")])]), r"record_dtype\(Pose\)"),
        (numpy.zeros((2, 7)), r"field poses\[\] must be of type geometry_msgs/Pose"),
    ],
)
def test_arrays_that_do_not_fit(value: Any, why: str) -> None:
    message = PoseArray(poses=value)
    for function in (codec.encode, codec.encode_frame, codec.copy, lambda wrong: wrong._check_types()):
        with pytest.raises(SerializationError, match=why):
            function(message)


def test_length_of_fixed_arrays_of_messages() -> None:
    cls: Any = from_definition("p/T", f"A[2] a\n{SEPARATOR}\nMSG: p/A\nint8 i")
    dtype = record_dtype(nested_classes(cls)["p/A"])
    assert codec.encode(cls(numpy.array([(1,), (2,)], dtype))) == b"\1\2"
    assert decoded(cls, b"\1\2").a["i"].tolist() == [1, 2]
    with pytest.raises(SerializationError, match="has 3 elements"):
        codec.encode(cls(numpy.zeros(3, dtype)))


def test_arrays_of_messages_of_no_fixed_size() -> None:
    cls: Any = from_definition("p/T", f"A[] a\n{SEPARATOR}\nMSG: p/A\nB b\n{SEPARATOR}\nMSG: p/B\nint8 i\nstring s")
    body = codec.encode(cls([nested_classes(cls)["p/A"]()]))
    assert isinstance(decoded(cls, body).a, list)
    with pytest.raises(TypeError, match=r"p/A has no fixed size \(field b.s is a string\): use a list of messages"):
        record_dtype(nested_classes(cls)["p/A"])
    with pytest.raises(SerializationError, match="field a must be a list of messages: p/A has no fixed size"):
        codec.encode(cls(numpy.zeros(1, [("b", [("i", "i1"), ("s", "O")])])))
    for wrong in (int, 3, "geometry_msgs/Pose"):
        with pytest.raises(TypeError, match="record_dtype takes a message class"):
            record_dtype(wrong)  # type: ignore[arg-type]


def test_names_that_arrays_have_too() -> None:
    cls: Any = from_definition("p/T", f"A[] a\n{SEPARATOR}\nMSG: p/A\nint8 data\nint8 size\nint8 shape")
    message = decoded(cls, b"\2\0\0\0abcdef")
    assert message.a["data"].tolist() == [97, 100] and message.a["size"].tolist() == [98, 101]
    assert codec.encode(message) == b"\2\0\0\0abcdef"
    assert [element.shape for element in codec.copy(message).a] == [99, 102]


def test_equality() -> None:
    body = codec.encode(poses())
    assert decoded(PoseArray, body) == decoded(PoseArray, body)
    for other in (poses(), poses(0), decoded(PoseArray, codec.encode(poses(1))), poses(2)):
        assert decoded(PoseArray, body) != other and other != decoded(PoseArray, body)


def test_too_few_bytes() -> None:
    body = codec.encode(poses())
    for size in (len(body) - 1, len(body) - 200):
        with pytest.raises(Exception, match=r"field poses claims 3 elements|poses needs"):
            decoded(PoseArray, body[:size])


def test_byte_arrays_that_are_cut() -> None:
    """As in stock ROS, a cut array of bytes counts; in a numpy array, which has one shape, zeros stay in its place."""
    cls: Any = from_definition("p/T", f"uint8[2] c\nA[1] a\nuint8[4] b\n{SEPARATOR}\nMSG: p/A\nuint8[2] u")
    message = decoded(cls, b"cceex")
    assert (bytes(message.c), message.a["u"].tolist(), bytes(message.b)) == (b"cc", [[101, 101]], b"x")
    message = decoded(cls, b"ccd")
    assert message.a["u"].tolist() == [[100, 0]]
    small = f"uint8[2] u\nB[2] b\n{SEPARATOR}\nMSG: p/B\nuint8[1] v"
    cls = from_definition("p/T", f"uint8[3] c\nA[2] a\n{SEPARATOR}\nMSG: p/A\n{small}")
    message = decoded(cls, b"c")
    assert (bytes(message.c), message.a["u"].tolist()) == (b"c", [[0, 0], [0, 0]])


def test_views_by_name() -> None:
    assert find_view(None) is None
    with pytest.raises(ValueError, match='arrays must be None, "memoryview" or "numpy", not \'list\''):
        find_view("list")
