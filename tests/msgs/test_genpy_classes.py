"""Message classes that pyros1 has not made: those of programs."""

from __future__ import annotations

import sys

import codec
import pytest

from pyros1.ground.timing import Time
from pyros1.msgs import Message, std_msgs
from pyros1.msgs.std_msgs.msg import Header


def test_a_program_s_own_class_without_a_definition() -> None:
    class Pair(Message):
        __slots__ = ["a", "b"]
        _slot_types = ["string", "std_msgs/Header"]

    assert (Pair().a, Pair().b) == (None, None)
    assert str(Pair("x", "y")) == 'a: "x"\nb: "y"'
    assert Pair(1, 2) == Pair(b=2, a=1)
    with pytest.raises(TypeError, match="Invalid number of arguments"):
        Pair(1)


def test_a_message_in_such_a_class_is_sent(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its class is found as genpy's classes find it: by importing it."""
    for name, module in (("std_msgs", std_msgs), ("std_msgs.msg", std_msgs.msg)):
        monkeypatch.setitem(sys.modules, name, module)

    class Outer(Message):
        __slots__ = ["count", "headers"]
        _slot_types = ["int8", "std_msgs/Header[]"]
        _type = "some_package/Outer"

    message = Outer(7, [Header(1, Time(2, 3), "map"), Header(4, Time(5, 6), "")])
    data = codec.encode(message)
    assert codec.decode(Outer, data, 0, len(data)) == message
