"""Where links are."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from robots import ALL, joint, pair

from pyros1.tf.transformations import quaternion_about_axis, quaternion_from_euler, quaternion_multiply
from pyros1.urdf.kinematics import Kinematics
from pyros1.urdf.model import UrdfError
from pyros1.urdf.reading import read_robot

ANGLES = st.floats(-50.0, 50.0)


def test_a_tree_with_all_types() -> None:
    kinematics = Kinematics(read_robot(ALL))
    assert kinematics.root == "base"
    assert {each.name for each, _ in kinematics.fixed} == {"plate", "slide"}
    assert set(kinematics.moving) == {"turn", "wheel", "lift", "twin", "another", "soft"}
    found = kinematics.transforms({"turn": 0.5, "lift": 0.7, "nobody": 1.0})
    assert {child: parent for child, (parent, _) in found.items()} == {
        **{"a": "base", "c": "b", "d": "c", "f": "base"},
        **{"g": "base", "h": "g"},  # which follow turn
    }
    assert found["c"][1] == pytest.approx((0.42, 0.0, 0.56, 0.0, 0.0, 0.0, 1.0))
    half = (2 * 0.5 + 0.25) / 2
    assert found["g"][1] == pytest.approx((0.0, 0.0, 0.0, 0.0, 0.0, math.sin(half), math.cos(half)))
    assert found["d"][1] == pytest.approx((0, 0, 0, 0, 0, math.sin(0.75), math.cos(0.75)))


def test_a_position_that_is_given_wins_over_mimic() -> None:
    positions = {"turn": 1.0, "twin": 0.5}
    Kinematics(read_robot(ALL)).add_mimic_joints(positions)
    assert positions == {"turn": 1.0, "twin": 0.5, "another": 1.5}


@given(ANGLES, st.tuples(ANGLES, ANGLES, ANGLES), st.tuples(ANGLES, ANGLES, ANGLES))
def test_rotations_are_those_of_matrices(
    angle: float, rpy: tuple[float, float, float], axis: tuple[float, float, float]
) -> None:
    if math.hypot(*axis) < 1e-3:
        return
    words = [" ".join(map(str, numbers)) for numbers in (rpy, axis)]
    robot = read_robot(pair(joint(f'<origin xyz="1 2 3" rpy="{words[0]}"/><axis xyz="{words[1]}"/>')))
    x, y, z, *rotation = Kinematics(robot).moving["j"].pose_at(angle)
    wanted = quaternion_multiply(quaternion_from_euler(*rpy), quaternion_about_axis(angle, axis))
    assert (x, y, z) == (1.0, 2.0, 3.0)
    assert abs(sum(a * b for a, b in zip(rotation, wanted, strict=True))) == pytest.approx(1.0)
    sign = rotation[3] if abs(rotation[3]) > 0.5 else max(rotation[:3], key=abs)
    assert sign > 0, "the quaternion's sign is that of a rotation matrix"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (pair(""), "2 links without a parent: one, two"),
        (
            pair(joint() + '<joint name="k" type="fixed"><parent link="two"/><child link="one"/></joint>'),
            "form a cycle",
        ),
        (
            '<robot><link name="root"/><link name="one"/><link name="two"/>'
            + joint()
            + '<joint name="k" type="fixed"><parent link="two"/><child link="one"/></joint></robot>',
            "form a cycle: one, two",
        ),
    ],
)
def test_links_that_are_no_tree(text: str, told: str) -> None:
    with pytest.raises(UrdfError, match=told):
        Kinematics(read_robot(text))


def test_a_long_chain() -> None:
    count = 5_000
    links = "".join(f'<link name="l{index}"/>' for index in reversed(range(count + 1)))
    chain = "".join(
        f'<joint name="j{index}" type="continuous"><parent link="l{index}"/><child link="l{index + 1}"/>'
        + (f'<mimic joint="j{index + 1}"/></joint>' if index + 1 < count else "</joint>")
        for index in range(count)
    )
    kinematics = Kinematics(read_robot(f"<robot>{links}{chain}</robot>"))
    assert kinematics.root == "l0"
    assert len(kinematics.transforms({f"j{count - 1}": 0.5})) == count
