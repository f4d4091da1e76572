"""Message classes that pyros1 has not made: those of programs."""

from __future__ import annotations

import pytest

from pyros1.msgs import Message


def test_a_program_s_own_class_without_a_definition() -> None:
    class Pair(Message):
        __slots__ = ["a", "b"]
        _slot_types = ["string", "std_msgs/Header"]

    assert (Pair().a, Pair().b) == (None, None)
    assert str(Pair("x", "y")) == 'a: "x"\nb: "y"'
    assert Pair(1, 2) == Pair(b=2, a=1)
    with pytest.raises(TypeError, match="Invalid number of arguments"):
        Pair(1)
