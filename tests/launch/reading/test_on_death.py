"""``on-death``: what is done when a node has ended.

Feature: a final message or a stop program when a launched node has exited -- `on-death="pub /cmd_vel
    geometry_msgs/Twist"`, `on-death="run my_robot brake"`
"""

from __future__ import annotations

import pytest

from pyros1.ground.errors import LaunchError
from pyros1.launch.reading.on_death import parse_on_death

from .test_loader import load


def test_the_forms() -> None:
    remappings = [("force_cmd", "/motor/force"), ("_rate", "10")]
    stop = parse_on_death(" pub force_cmd std_msgs/Float64 0.0", "/robot/", "me", remappings)
    assert stop is not None and (stop.kind, stop.words) == ("pub", ("/motor/force", "std_msgs/Float64", "0.0"))
    stop = parse_on_death("pub ~stop geometry_msgs/Twist '{linear: {x: 0}}'", "/robot/", "me", [])
    assert stop is not None and stop.words == ("/robot/me/stop", "geometry_msgs/Twist", "{linear: {x: 0}}")
    assert str(stop) == "pub /robot/me/stop geometry_msgs/Twist '{linear: {x: 0}}'"
    stop = parse_on_death("run my_robot brake --hard", "/", "me", [])
    assert stop is not None and (stop.kind, stop.words) == ("run", ("my_robot", "brake", "--hard"))
    assert parse_on_death("", "/", "me", []) is None


@pytest.mark.parametrize("text", ["shutdown", "pub /t", "run brake", "pubb /t std_msgs/Empty", "'pub'"])
def test_other_forms_are_refused(text: str) -> None:
    with pytest.raises(LaunchError, match=r"'on-death' cannot be .* use pub TOPIC TYPE VALUE, or run PACKAGE PROGRAM"):
        parse_on_death(text, "/", "me", [])


def test_quotes_must_match() -> None:
    with pytest.raises(LaunchError, match="cannot split the 'on-death' attribute"):
        parse_on_death("pub 't", "/", "me", [])


def test_in_a_file() -> None:
    plan = load(
        """<launch>
        <arg name="stop" default="0.5"/>
        <group ns="g">
            <remap from="force_cmd" to="force"/>
            <node pkg="p" type="t" name="a" on-death="pub force_cmd std_msgs/Float64 $(arg stop)"/>
            <node pkg="p" type="t" name="b" on-death="run p brake"/>
            <node pkg="p" type="t" name="c"/>
        </group>
        </launch>"""
    )
    a, b, c = plan.nodes
    assert str(a.on_death) == "pub /g/force std_msgs/Float64 0.5" and a.on_death_plan is None
    assert b.on_death_plan is not None and c.on_death is None and c.on_death_plan is None
    assert (b.on_death_plan.full_name, b.on_death_plan.type, b.on_death_plan.remappings) == (
        "/g/b_on_death",
        "brake",
        b.remappings,
    )
    assert not plan.warnings


def test_a_test_has_none() -> None:
    with pytest.raises(LaunchError, match="<test> tags cannot have 'on-death' attribute"):
        load('<launch><test pkg="p" type="t" test-name="a" on-death="run p brake"/></launch>')
