"""Field paths behind topic names (L60)."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.msgs.geometry_msgs.msg import Point, Pose, PoseArray, PoseStamped
from pyros1.msgs.sensor_msgs.msg import JointState
from pyros1.observe.fields import FieldPath, FieldPathError, expand_fields, split_expression


def _poses() -> PoseArray:
    return PoseArray(poses=[Pose(position=Point(x, 0.0, 0.0)) for x in (0.0, 1.0, 2.0)])


@pytest.mark.parametrize(
    ("path", "value", "kind"),
    [
        ("/poses[1]/position/x", 1.0, "float64"),
        ("/poses[0:2]/position/x", [0.0, 1.0], "float64[]"),
        ("/poses[::2]/position/x", [0.0, 2.0], "float64[]"),
        ("/poses[-1]/position/x", 2.0, "float64"),
        ("/poses[5:]/position/x", [], None),
        ("/header/frame_id", "", "string"),
        ("/header/stamp/secs", 0, "int32"),
    ],
)
def test_a_path_leads_to_value_and_type(path: str, value: object, kind: str | None) -> None:
    assert FieldPath(path).get(_poses()) == (value, kind)


@pytest.mark.parametrize(
    ("text", "curves"),
    [
        ("/a/x:y:z", ["/a/x", "/a/y", "/a/z"]),
        ("/a/x,/b[0:2]/y", ["/a/x", "/b[0:2]/y"]),
        ("/a/m:n", ["/a/m", "/a/n"]),
        ("/a: hypot(m.x, m.y)", ["/a: hypot(m.x, m.y)"]),
        ("/a:m.x*2", ["/a:m.x*2"]),
        ("/a/x,/b: m.y * 2", ["/a/x", "/b: m.y * 2"]),
        ("/a: 5", ["/a: 5"]),
        ("/js/position[0]:velocity[0]", ["/js/position[0]", "/js/velocity[0]"]),
        ("/js/position[-1]:velocity[1]:effort[2]", ["/js/position[-1]", "/js/velocity[1]", "/js/effort[2]"]),
        ("/a/x:y[0]", ["/a/x", "/a/y[0]"]),
        ("/a/p[0]/x:y", ["/a/p[0]/x", "/a/p[0]/y"]),
        ("/a/p[0]:q[1]/x", ["/a/p[0]", "/a/q[1]/x"]),
        ("/a/p[0:2]:q[1:5:2],/b/x:y", ["/a/p[0:2]", "/a/q[1:5:2]", "/b/x", "/b/y"]),
        ("/a/p[0:2]/x", ["/a/p[0:2]/x"]),
        ("/a/x[0],/b: m.y[0] * 2", ["/a/x[0]", "/b: m.y[0] * 2"]),
        ("/b: m.y[0] - m.y[1]", ["/b: m.y[0] - m.y[1]"]),
        ("/a/x:,,/b/y", ["/a/x", "/b/y"]),
    ],
)
def test_the_curves_of_an_argument(text: str, curves: list[str]) -> None:
    """tests/web/page/plot.test.mjs has the same of the page."""
    assert expand_fields(text) == curves


def test_an_expression_behind_a_topic() -> None:
    assert split_expression(" b : -m.x ") == ("b", "-m.x")
    assert split_expression("/a/x:y") is None


def test_the_empty_path_is_the_message() -> None:
    message = _poses()
    assert FieldPath("").get(message) == (message, None)


@pytest.mark.parametrize("path", ["/poses[7]", "/nope", "/header/__class__", "/header/stamp/to_sec", "/header/seq/x"])
def test_a_path_that_leads_nowhere_is_an_error(path: str) -> None:
    with pytest.raises(FieldPathError):
        FieldPath(path).get(_poses())


@pytest.mark.parametrize("path", ["/a[x]", "/a[1:2:3:4]", "/a[]", "/a[::0]", "/a[", "/1a", "/a//b"])
def test_a_malformed_path_is_an_error(path: str) -> None:
    with pytest.raises(FieldPathError):
        FieldPath(path)


@pytest.mark.parametrize(
    ("path", "kind"),
    [
        ("/header/stamp", "time"),
        ("/pose/position/x", "float64"),
        ("/header/stamp/nsecs", "int32"),
        ("", "geometry_msgs/PoseStamped"),
    ],
)
def test_the_type_of_a_field_is_known_without_a_message(path: str, kind: str) -> None:
    """L29"""
    assert FieldPath(path).type_in(PoseStamped) == kind


def test_the_type_of_elements() -> None:
    assert FieldPath("/name[0]").type_in(JointState) == "string"
    assert FieldPath("/poses[:]/position").type_in(PoseArray) == "geometry_msgs/Point[]"
    with pytest.raises(FieldPathError):
        FieldPath("/nope").type_in(JointState)


@given(st.text(alphabet="abp/[]:-1 _", max_size=30))
def test_any_text_is_a_path_or_the_documented_error(text: str) -> None:
    with contextlib.suppress(FieldPathError):
        FieldPath(text).get(_poses())
