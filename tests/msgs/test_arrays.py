"""Arrays of numbers."""

from __future__ import annotations

import struct
from array import array

import pytest

from pyros1.msgs.arrays import Packers


@pytest.mark.parametrize(("code", "type_code"), [("d", "d"), ("i", "i"), ("q", "l"), ("q", "q")])
def test_an_array_of_the_right_format_is_copied_as_it_is(code: str, type_code: str) -> None:
    packers, values = Packers(code), array(type_code, range(7))
    assert packers.pack(values) == struct.pack(f"<7{code}", *values)
    assert not packers, "no function that packs seven numbers was needed"


def test_an_array_of_another_format_is_packed_element_by_element() -> None:
    packers, values = Packers("d"), array("f", range(7))
    assert packers.pack(values) == struct.pack("<7d", *values)
    assert list(packers) == [7]
