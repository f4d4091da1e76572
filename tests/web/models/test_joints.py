"""What the panel of joints shows and sends."""

from __future__ import annotations

import pytest

from pyros1.urdf.joints import JointStates, Options
from pyros1.urdf.reading import read_robot
from pyros1.web.models import joints
from pyros1.web.server.wire import RequestError

FINGERS = """
<robot name="fingers"><link name="palm"/><link name="left"/><link name="right"/>
<joint name="left" type="prismatic"><parent link="palm"/><child link="left"/><limit lower="0.5" upper="1"/></joint>
<joint name="right" type="prismatic"><parent link="palm"/><child link="right"/><limit lower="0" upper="1"/>
<mimic joint="left" multiplier="-2" offset="0.5"/></joint></robot>
"""


def test_followers_have_the_limits_of_their_leaders() -> None:
    assert joints.describe(JointStates(read_robot(FINGERS), Options())) == [
        {"name": "left", "type": "prismatic", "lower": 0.5, "upper": 1.0, "zero": 0.75},
        {"name": "right", "type": "prismatic", "lower": -1.5, "upper": -0.5, "zero": -1.0, "follows": "left"},
    ]


def test_long_lists_are_cut() -> None:
    count = joints.MAX_JOINTS + 5
    links = "".join(f'<link name="l{index}"/>' for index in range(count + 1))
    chain = "".join(
        f'<joint name="j{index}" type="continuous"><parent link="l0"/><child link="l{index + 1}"/></joint>'
        for index in range(count)
    )
    assert (
        len(joints.describe(JointStates(read_robot(f"<robot>{links}{chain}</robot>"), Options()))) == joints.MAX_JOINTS
    )


def test_topics_on_which_a_node_takes_positions() -> None:
    assert joints.position_topics("/ns/jsp", {"source_list": ["more", "/all", 5, "not legal!"]}) == [
        *("/ns/jsp/sliders", "/ns/more", "/all"),
    ]
    assert joints.position_topics("/jsp", {"source_list": "x"}) == joints.position_topics("/jsp", 5) == ["/jsp/sliders"]


def test_parameters_with_another_meaning() -> None:
    assert joints.publisher_options({"rate": "fast"}) == joints.publisher_options(None) == Options()
    assert joints.publisher_options({"zeros": {"left": 0.6}}).zeros == {"left": 0.6}


@pytest.mark.parametrize(
    "value", [[], {"a": "b"}, {"a": True}, {"a": 1e999}, {"a": None}, dict.fromkeys(range(2000), 1)]
)
def test_positions_are_numbers(value: object) -> None:
    with pytest.raises(RequestError):
        joints.check_positions(value)
    assert joints.check_positions({"a": 1}) == {"a": 1}
