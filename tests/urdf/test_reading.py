"""Descriptions of robots are read, and faults in them are named."""

from __future__ import annotations

import pytest
from robots import ALL, joint, pair

from pyros1.urdf.model import Limit, Mimic, UrdfError
from pyros1.urdf.reading import MAX_DESCRIPTION_LENGTH, read_robot

pytestmark = pytest.mark.once


def test_all_that_moves_links_is_read() -> None:
    robot = read_robot('<?xml version="1.0" encoding="utf-8"?>' + ALL.strip())
    assert (robot.name, robot.links[:3], robot.warnings) == ("all", ("base", "a", "b"), ())
    assert [each.type for each in robot.joints.values()] == [
        *("revolute", "continuous", "prismatic", "fixed", "floating", "planar"),
        *("revolute", "continuous", "revolute"),
    ]
    turn = robot.joints["turn"]
    assert (turn.parent, turn.child, turn.origin[:3]) == ("base", "a", (1.0, 2.0, 3.0))
    assert turn.axis == pytest.approx((0, 2 / 5**0.5, 1 / 5**0.5))
    assert turn.limit == Limit(-1.0, 2.0)
    assert robot.joints["twin"].mimic == Mimic("turn", 2.0, 0.25)
    assert robot.joints["soft"].limit == Limit(-3.0, 3.0, 0.2, 1.0)
    assert robot.joints["wheel"].axis == (1.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("", "not readable XML"),
        ("<robot>", "not readable XML"),
        ('<robot><xacro:include filename="x"/></robot>', "is it xacro"),
        ('<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arm/></robot>', "is xacro, not URDF"),
        ('<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema"/>', "COLLADA"),
        ("<sdf/>", "root element is <sdf>"),
        ("<robot/>", "no links"),
        ("<robot><link/></robot>", "a link has no name"),
        ('<robot><link name="a"/><link name="a"/></robot>', "two links a"),
        ('<!DOCTYPE r [<!ENTITY a "aaaa">]><robot name="&a;"/>', "not readable XML"),
        (pair('<joint type="fixed"/>'), "a joint has no name"),
        (pair(joint(type="hinge")), "its type is hinge; valid types are continuous"),
        (pair('<joint name="j" type="fixed"><parent link="one"/></joint>'), "joint j has no child"),
        (pair(joint(type="revolute")), "has no <limit>: add <limit .*continuous"),
        (pair(joint('<axis xyz="1 0"/>')), 'joint j: <axis xyz="1 0"> must be three numbers'),
        (pair(joint('<origin rpy="0 0 x"/>')), "three numbers"),
        (pair(joint('<origin xyz="0 0 inf"/>')), "three numbers"),
        (pair(joint('<limit lower="low"/>', "prismatic")), "must be a number"),
        (pair(joint("<mimic/>")), "its mimic element has no joint"),
        (pair(joint('<mimic joint="j"/>')), "follows itself"),
        (pair(joint() + joint()), "two joints j"),
        (pair(joint() + joint(name="k")), "link two is the child of two joints, j and k"),
        (
            pair(joint().replace('"two"', '"twoo"')),
            r"its child twoo is not a link of the robot \(did you mean 'two'\?\)",
        ),
        (" " * (MAX_DESCRIPTION_LENGTH + 1), "more than"),
    ],
)
def test_faults_are_named(text: str, hint: str) -> None:
    with pytest.raises(UrdfError, match=hint):
        read_robot(text)


def test_oddities_are_warnings() -> None:
    still = read_robot(pair(joint('<axis xyz="0 0 0"/><mimic joint="jj"/>')))
    assert still.joints["j"].axis == (0.0, 0.0, 0.0)
    assert [text.partition(",")[0] for text in still.warnings] == [
        "joint j has the axis 0 0 0: the joint does not move",
        "joint j mimics jj",
    ]


def test_names_cannot_reach_a_terminal() -> None:
    with pytest.raises(UrdfError) as found:
        read_robot(pair(joint(type="&#x9b;31m")))
    assert "\x9b" not in str(found.value)


@pytest.mark.slow
def test_many_joints_are_read_in_time() -> None:
    count = 20_000
    links = "".join(f'<link name="l{index}"/>' for index in range(count + 1))
    chain = "".join(
        f'<joint name="j{index}" type="continuous"><parent link="l{index}"/><child link="l{index + 1}"/>'
        f'<mimic joint="j{index - 1 if index else count - 1}0"/></joint>'
        for index in range(count)
    )
    robot = read_robot(f"<robot>{links}{chain}</robot>")
    assert len(robot.joints) == count
    assert len(robot.warnings) == 51 and "more like these" in robot.warnings[-1]
