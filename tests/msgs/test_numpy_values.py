"""Values of numpy in messages: what a program computes goes into fields as it is, or is refused."""

from __future__ import annotations

from typing import Any

import codec
import pytest

from pyros1.ground.errors import SerializationError
from pyros1.msgs import from_definition

numpy = pytest.importorskip("numpy")

TRUE, FALSE = numpy.array([1.0]).any(), numpy.float64(1) > 2


def both(definition: str, value: Any) -> Any:
    """Return the field of a message as a receiver in another process and one in the same process get it."""
    cls: Any = from_definition("p/T", definition)
    message = cls(value)
    decoded, copied = cls().deserialize(codec.encode(message)), codec.copy(message)
    assert decoded == copied
    return decoded.x


@pytest.mark.filterwarnings("ignore:In future, it will be an error:DeprecationWarning")  # says numpy before 2.3
def test_booleans_that_were_computed() -> None:
    """New versions of numpy no longer have them as indices."""
    assert (both("bool x", TRUE), both("bool x", FALSE)) == (True, False)
    assert both("bool[] x", [TRUE, False, FALSE]) == [True, False, False]
    assert both("bool[2] x", (TRUE, FALSE)) == [True, False]
    assert both("bool[] x", numpy.array([1, 0]) > 0) == [True, False]
    assert both("bool[] x", [TRUE] * 1000) == [True] * 1000


@pytest.mark.filterwarnings("ignore:In future, it will be an error:DeprecationWarning")  # says numpy before 2.3
@pytest.mark.parametrize("definition", ["uint8[] x", "uint8[2] x", "char[] x"])
def test_booleans_in_lists_of_bytes(definition: str) -> None:
    assert both(definition, [TRUE, 3]) == both(definition, (TRUE, numpy.uint8(3))) == b"\1\3"


@pytest.mark.parametrize("value", [numpy.array([True, False]), numpy.float64(1), numpy.array(["a"])])
def test_what_is_not_one_boolean(value: Any) -> None:
    with pytest.raises(SerializationError, match=r"field x is not a bool|not an integer"):
        both("bool x", value)


@pytest.mark.parametrize("definition", ["uint8[] x", "uint8[4] x", "char[] x"])
def test_arrays_of_wide_numbers_are_no_bytes(definition: str) -> None:
    """Their bytes would be sent in place of their numbers: no program notices."""
    image = numpy.array([[1, 2], [3, 4]], dtype=numpy.uint8)
    assert both(definition, image) == bytes([1, 2, 3, 4])
    assert both(definition, image[:, ::-1]) == bytes([2, 1, 4, 3])
    for kind in (numpy.int64, numpy.uint16, numpy.float32):
        with pytest.raises(SerializationError, match=r"uint8, but got an array of \w+: pass array.tobytes\(\)"):
            both(definition, image.astype(kind))
    wide = memoryview(image.astype(numpy.uint16)[0])
    if definition != "uint8[4] x":
        with pytest.raises(SerializationError, match=r"array of numbers other"):
            both(definition, wide)


IGNORED = pytest.mark.filterwarnings("ignore:Conversion of an array:DeprecationWarning")  # says numpy before 2.4
ONE = [numpy.array([1.5]), numpy.array([[1.5]]), numpy.array([1.5], dtype="f4"), numpy.array([1.5], dtype=object)]
ONE += [numpy.array(1.5), numpy.ma.array([1.5])]


@IGNORED
@pytest.mark.parametrize("value", ONE, ids=repr)
@pytest.mark.parametrize("kind", ["float32", "float64"])
def test_an_array_of_one_element_is_a_float(kind: str, value: Any) -> None:
    """numpy 2.4 has ended the conversion."""
    assert both(f"{kind} x", value) == 1.5
    assert both(f"{kind}[] x", [value, 2.0]) == (1.5, 2.0)
    assert both(f"{kind}[2] x", (value, 2.0)) == (1.5, 2.0)
    assert both(f"{kind}[] x", [value] * 300) == (1.5,) * 300


@IGNORED
def test_a_column_is_an_array_of_floats() -> None:
    column = numpy.array([[1.5], [2.0]])
    assert both("float64[] x", column) == both("float32[2] x", column) == (1.5, 2.0)
    assert both("float64[] x", numpy.ones((300, 1))) == (1.0,) * 300
    for wrong in (numpy.ones((2, 2)), [numpy.array([1.0, 2.0])], [numpy.array([])], [numpy.array([1j])]):
        with pytest.raises(SerializationError, match=r"field x\[\] must be float type"):
            both("float64[] x", wrong)


@IGNORED
def test_in_nested_messages_and_beside_wrong_values() -> None:
    one = numpy.array([1.5])
    text = "P p\nP[] ps\nstring s\n" + "=" * 80 + "\nMSG: p/P\nfloat64 x\nint32 n\n"
    cls: Any = from_definition("p/T", text)
    inner = type(cls().p)
    message = cls(inner(one, 1), [inner(one, 2), inner(2.5, 3)], "s")
    frame = codec.encode_frame(message)
    for made in (*(cls().deserialize(body) for body in (codec.encode(message), frame[4:])), codec.copy(message)):
        assert [made.p.x, *(each.x for each in made.ps), made.p.n, made.s] == [1.5, 1.5, 2.5, 1, "s"]
    assert message.p.x is one
    for wrong, names in ((cls(inner(one, "n"), [], "s"), "p.n"), (cls(inner(one, 1), [], 3), "s")):
        with pytest.raises(SerializationError, match=f"field {names} "):
            codec.encode(wrong)


@pytest.mark.filterwarnings("ignore:In future, it will be an error:DeprecationWarning")  # says numpy before 2.3
def test_booleans_are_integers() -> None:
    assert (both("int8 x", TRUE), both("uint64 x", FALSE)) == (1, 0)
    assert both("int32[] x", numpy.array([True, False])) == (1, 0)
    for wrong in (numpy.array([1]), numpy.float64(1), numpy.array([True])):
        with pytest.raises(SerializationError, match="field x must be"):
            both("int32 x", wrong)
