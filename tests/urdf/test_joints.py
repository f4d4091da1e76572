"""States of joints, as joint_state_publisher says them."""

from __future__ import annotations

from typing import Any

import pytest
from robots import ALL, joint, pair

from pyros1.urdf.joints import JointStates, Options, read_options
from pyros1.urdf.model import UrdfError
from pyros1.urdf.reading import read_robot

NAMES = ["turn", "wheel", "lift", "twin", "another", "soft"]


def states(text: str = ALL, **given: Any) -> JointStates:
    return JointStates(read_robot(text), read_options(given.get))


def test_defaults_are_those_of_stock() -> None:
    found = states()
    assert read_options(lambda name, default: default) == Options()
    assert found.message_fields() == (NAMES, [0.0, 0.0, 0.75, 0.25, 0.75, 0.6], [], [])
    assert [(each.lower, each.upper) for each in found.free_joints.values()] == [
        *((-1.0, 2.0), (-3.141592653589793, 3.141592653589793), (0.5, 1.0), (0.2, 1.0)),
    ]


def test_all_parameters() -> None:
    found = states(
        zeros={"wheel": 0.3, "turn": 7},
        publish_default_velocities=True,
        publish_default_efforts=True,
        use_smallest_joint_limits=False,
        use_mimic_tags=False,
        dependent_joints={"soft": {"parent": "wheel", "factor": -2, "offset": 0.1}},
    )
    assert found.message_fields()[1] == pytest.approx([7.0, 0.3, 0.75, 0.0, 0.0, -0.5])
    found.apply(["wheel", "nobody", "soft"], [1.0, 2.0, 9.0], [0.5, 1.0], [3.0, 4.0])
    _, positions, velocities, efforts = found.message_fields()
    assert positions == pytest.approx([7.0, 1.0, 0.75, 0.0, 0.0, -1.9])
    assert velocities == [0.0, 0.5, 0.0, 0.0, 0.0, -1.0]
    assert efforts == [0.0, 3.0, 0.0, 0.0, 0.0, 3.0]


def test_without_defaults_there_is_what_sources_say() -> None:
    found = states(publish_default_positions=False, use_mimic_tags=False)
    assert found.message_fields() == (NAMES, [], [], [])
    found.apply(["wheel", "lift"], [], [1.0])
    assert found.message_fields() == (NAMES, [], [0.0, 1.0, 0.0, 0.0, 0.0, 0.0], [])
    found.apply(["lift"], [9.0, 8.0])
    assert found.message_fields()[1] == [0.0, 0.0, 9.0, 0.0, 0.0, 0.0]
    assert states(publish_default_positions=False).message_fields()[1] == [0.0] * 6  # with followers


def test_numbers_that_are_none_are_passed_over() -> None:
    found = states()
    found.apply(["turn", "wheel"], [float("nan"), float("inf")])
    assert found.message_fields()[1][:2] == [0.0, 0.0]


def test_followers_of_followers_and_circles() -> None:
    found = states(dependent_joints={"turn": {"parent": "wheel", "factor": 2, "offset": 1}})
    found.apply(["wheel"], [1.0])
    assert found.message_fields()[1][:5] == [3.0, 1.0, 0.75, 6.25, 18.75]
    circle = states(dependent_joints={"turn": {"parent": "wheel"}, "wheel": {"parent": "turn"}})
    assert "turn" in circle.free_joints and circle.followers["wheel"].joint == "turn"
    assert circle.warnings == ["joint turn follows itself, so it is treated as a free joint"]
    lost = states(dependent_joints={"turn": {"parent": "nobody"}, "ghost": {"parent": "turn"}})
    assert "turn" in lost.free_joints and lost.followers["twin"].joint == "turn"
    assert lost.warnings == [
        "ghost has a parameter, but there is no movable joint of this name",
        "joint turn follows nobody, which does not move",
    ]


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"rate": 0}, "rate must be above 0"),
        ({"rate": "fast"}, "rate must be a number"),
        ({"source_list": "/here"}, "source_list must be a list"),
        ({"source_list": ["/here"] * 101}, "more than 100"),
        ({"zeros": [1]}, "zeros must be a mapping"),
        ({"zeros": {"turn": "a"}}, "zeros/turn must be a number"),
        ({"dependent_joints": {"turn": {}}}, "dependent_joints/turn must have a parent"),
        ({"dependent_joints": {"turn": {"parent": "wheel", "factor": True}}}, "factor must be a number"),
    ],
)
def test_wrong_parameters_are_named(given: dict[str, Any], told: str) -> None:
    with pytest.raises(UrdfError, match=told):
        states(**given)


def test_delta_goes_to_and_fro() -> None:
    found = states(pair(joint('<limit lower="-0.2" upper="0.1"/>', "prismatic")), delta=0.1)
    seen = []
    for _ in range(8):
        found.step()
        seen += found.message_fields()[1]
    assert seen == pytest.approx([0.1, 0.1, 0.0, -0.1, -0.2, -0.2, -0.1, 0.0])
