"""Messages from plain values (G26)."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import MessageError
from pyros1.ground.timing import Duration, Time
from pyros1.msgs import from_definition
from pyros1.msgs.fill import fill_message

SEPARATOR = "=" * 80
Point: Any = from_definition("p/Point", "float64 x\nfloat64 y")
Outer: Any = from_definition("p/Outer", f"Point p\n{SEPARATOR}\nMSG: p/Point\nfloat64 x\nfloat64 y")
T: Any = from_definition(
    "p/T",
    "Header header\nint32 i\ntime t\nduration d\nint32[] a\nfloat64[2] f\nstring[] s\ntime[] ts\nuint8[] u\n"
    f"Point[] ps\nPoint[1] one\n{SEPARATOR}\nMSG: p/Point\nfloat64 x\nfloat64 y",
)
NOW = Time(7, 8)


def filled(cls: Any, args: Any) -> Any:
    message = cls()
    fill_message(message, args, NOW)
    return message


@pytest.mark.parametrize("args", [[1, 2], {"x": 1, "y": 2}, [{"x": 1, "y": 2}], (1, 2)])
def test_list_dict_and_dict_in_a_list(args: Any) -> None:
    assert filled(Point, args) == Point(1, 2)


def test_partial_dicts_keep_defaults() -> None:
    assert filled(Point, {"y": 2}) == Point(0.0, 2)
    assert filled(Point, {}) == filled(Point, [{}]) == Point()
    assert filled(Outer, {"p": {"x": 1}}).p.x == filled(Outer, {"p": [1, 2]}).p.x == filled(Outer, [[1, 2]]).p.x == 1


def test_keys_now_and_auto() -> None:
    assert filled(T, {"t": "now"}).t == NOW
    assert filled(T, {"header": "auto"}).header.stamp == NOW
    assert filled(T, {"header": {"stamp": "now", "frame_id": "now"}}).header.frame_id == "now"
    with pytest.raises(MessageError, match=r"No key named \[now\]"):
        fill_message(T(), {"t": "now"})
    with pytest.raises(MessageError, match=r"No key named \[later\]"):
        filled(T, {"t": "later"})


def test_times() -> None:
    assert filled(T, {"t": 5_000_000_001}).t == Time(5, 1)
    assert filled(T, {"d": -1}).d == Duration(0, -1)
    assert filled(T, {"t": [1, 2]}).t == filled(T, {"t": {"secs": 1, "nsecs": 2}}).t == Time(1, 2)
    assert filled(T, {"t": {"nsecs": 3}}).t == Time(0, 3)
    carried = filled(T, {"t": [1, 1_500_000_000]}).t
    assert (carried.secs, carried.nsecs) == (2, 500_000_000)
    assert filled(T, {"ts": [1, {"secs": 2}, "now"]}).ts == [Time(0, 1), Time(2), NOW]


def test_arrays() -> None:
    message = filled(T, {"a": [1, 2], "s": ["x"], "u": [1, 2], "ps": [{"x": 1}, [3, 4]], "one": [[5, 6]]})
    assert (message.a, message.s, message.u) == ([1, 2], ["x"], [1, 2])
    assert [(point.x, point.y) for point in [*message.ps, *message.one]] == [(1, 0.0), (3, 4), (5, 6)]
    assert filled(T, {"u": b"ab"}).u == b"ab"


@pytest.mark.parametrize(
    ("cls", "args", "text"),
    [
        (Point, [1], "Not enough arguments:\n * Given: [1]\n * Expected: ['x', 'y']"),
        (Point, [1, 2, 3], "Too many arguments:\n * Given: [1, 2, 3]\n * Expected: ['x', 'y']"),
        (Point, None, "Not enough arguments:\n * Given: []\n * Expected: ['x', 'y']"),
        (Point, {"z": 1}, "No field name [z]"),
        (Point, 5, "invalid msg_args type: 5"),
        (Outer, {"p": {"z": 1}}, "No field name [p.z]"),
        (Outer, {"p": 5}, "invalid msg_args type: 5"),
        (Outer, {"p": None}, "No key named []"),
        (T, {"t": 1.5}, "invalid msg_args type: 1.5"),
        (T, {"t": True}, "invalid msg_args type: True"),
        (T, {"t": -5}, "Field [t]: time values must be positive"),
        (T, {"t": [-5, 0]}, "Field [t]: time values must be positive"),
        (T, {"t": {"secs": "a"}}, "Field [t.secs] must be an integer instead of: str"),
        (T, {"t": [1]}, "Not enough arguments:\n * Given: [1]\n * Expected: ['secs', 'nsecs']"),
        (T, {"t": "auto"}, "No key named [auto]"),
        (T, {"a": 5}, "Field [a] must be a list or tuple instead of: int"),
        (T, {"u": 5}, "Field [u] must be a list or tuple instead of: int"),
        (T, {"s": "abc"}, "Field [s] must be a list or tuple instead of: str"),
        (T, {"f": [1, 2, 3]}, "Field [f] has incorrect number of elements: 3 != 2"),
        (T, {"one": []}, "Field [one] has incorrect number of elements: 0 != 1"),
        (T, {"ps": [5]}, "invalid msg_args type: 5"),
        (
            T,
            {"header": [1, "now"]},
            "Not enough arguments:\n * Given: [1, 'now']\n * Expected: ['seq', 'stamp', 'frame_id']",
        ),
    ],
)
def test_error_texts(cls: Any, args: Any, text: str) -> None:
    with pytest.raises(MessageError) as caught:
        filled(cls, args)
    assert str(caught.value) == text


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.sampled_from(["now", "auto", "x", ""]),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from([*T.__slots__, "x", "y", "secs", "nsecs", "stamp", "z"]), inner, max_size=3)
    ),
)


@given(JSON)
def test_any_plain_value_fills_or_is_refused(args: Any) -> None:
    for cls in (T, Point, Outer):
        try:
            filled(cls, args)
        except MessageError as error:
            assert str(error)
