"""Messages as trees for reading."""

from __future__ import annotations

import json

from hypothesis import given
from hypothesis import strategies as st

from pyros1 import Time
from pyros1.msgs.geometry_msgs.msg import PoseArray, PoseStamped
from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.msgs.std_msgs.msg import Float64MultiArray, Int64, String
from pyros1.web.views.message import tree


def test_fields_types_and_times() -> None:
    message = PoseStamped()
    message.header.stamp = Time(3, 4)
    shown = tree(message)
    assert [field[:2] for field in shown["fields"]] == [["header", "std_msgs/Header"], ["pose", "geometry_msgs/Pose"]]
    assert shown["fields"][0][2]["fields"][1] == ["stamp", "time", {"secs": 3, "nsecs": 4}]


def test_large_arrays_are_cut_and_say_how_long_they_are() -> None:
    data = tree(Image(data=bytes(1_000_000)))["fields"][-1][2]
    assert data["length"] == 1_000_000
    assert data["items"] == [0] * 64
    poses = PoseArray(poses=[PoseStamped().pose] * 500)
    assert len(json.dumps(tree(poses))) < 100_000


@given(st.lists(st.floats(), max_size=100), st.text(max_size=50), st.integers(-(2**63), 2**63 - 1))
def test_any_value_is_json(numbers: list[float], text: str, whole: int) -> None:
    for message in (Float64MultiArray(data=numbers), String(text), Int64(whole)):
        json.dumps(tree(message), allow_nan=False).encode()
    shown = tree(Int64(whole))["fields"][0][2]
    assert int(shown) == whole
    assert isinstance(shown, str) == (abs(whole) >= 2**53)  # which JavaScript's numbers could not hold


def test_a_long_text_is_cut() -> None:
    assert len(tree(String("x" * 100_000))["fields"][0][2]) < 3000
