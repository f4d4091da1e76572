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
        with pytest.raises(SerializationError, match=r"field x takes bytes or an array of uint8, not of \w+: give its"):
            both(definition, image.astype(kind))
    wide = memoryview(image.astype(numpy.uint16)[0])
    if definition != "uint8[4] x":
        with pytest.raises(SerializationError, match=r"array of other numbers"):
            both(definition, wide)
