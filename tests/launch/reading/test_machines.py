"""``<machine>`` tags: settings, defaults, and what is refused (X49-X54, X61, X68). With stock's in interop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from pyros1.ground.errors import LaunchError
from pyros1.launch.plan import MachinePlan, Plan
from pyros1.launch.reading.loader import load_plan
from pyros1.launch.reading.system_resources import make_resources

Load = Callable[..., Plan]


@pytest.fixture
def load(tmp_path: Path) -> Load:
    """Return a function that reads the elements of a launch file."""
    resources = replace(make_resources(), environ={"ROBOT_HOST": "arm.example"})
    path = tmp_path / "main.launch"

    def load(text: str, **args: str) -> Plan:
        path.write_text(f"<launch>\n{text}\n</launch>")
        return load_plan([str(path)], args, resources)

    return load


def node(name: str, more: str = "") -> str:
    return f'<node pkg="p" type="t" name="{name}" {more}/>'


def test_settings_are_kept_as_they_are_written(load: Load) -> None:
    text = '<machine name="$(arg robot)" address="$(env ROBOT_HOST)" env-loader="/opt/$(arg robot)/env.sh" user="me"/>'
    plan = load(f'<arg name="robot"/>{text}<machine name="pc" address="localhost"/>', robot="r2")
    assert plan.machines == {
        "r2": MachinePlan("r2", "arm.example", (("env-loader", "/opt/r2/env.sh"), ("user", "me"))),
        "pc": MachinePlan("pc", "localhost"),
    }
    assert list(plan.machines) == ["r2", "pc"]


@pytest.mark.parametrize(
    ("more", "setting"),
    [
        ('ssh-port="2222"', ("ssh-port", "2222")),
        ('ssh-port=""', ("ssh-port", "")),
        ('timeout="0.5"', ("timeout", "0.5")),
        ('password="secret"', ("password", "secret")),
        ('default="never"', ("default", "never")),
        ('default=""', ("default", "")),
    ],
)
def test_each_setting(load: Load, more: str, setting: tuple[str, str]) -> None:
    plan = load(f'<machine name="m" address="h" {more}/>')
    assert plan.machines["m"].settings == (setting,)


def test_an_empty_address_is_declared_but_not_yet_wrong(load: Load) -> None:
    """Files use it as the default of an argument; a node that is to run there is refused later."""
    assert load('<machine name="m" address=""/>').machines == {"m": MachinePlan("m", "")}


def machines_of_nodes(plan: Plan) -> dict[str, Any]:
    return {each.name: each.machine for each in plan.nodes}


def test_the_default_machine_is_that_of_later_nodes_without_one(load: Load) -> None:
    declared = '<machine name="a" address="h"/><machine name="b" address="h" default="TRUE"/>'
    plan = load(node("early") + declared + node("late") + node("own", 'machine="a"'))
    assert machines_of_nodes(plan) == {"early": None, "late": "b", "own": "a"}


@pytest.mark.parametrize("value", ["false", "never", ""])
def test_other_machines_are_no_default(load: Load, value: str) -> None:
    plan = load(f'<machine name="m" address="h" default="{value}"/>' + node("n"))
    assert machines_of_nodes(plan) == {"n": None}


def test_the_last_default_counts_and_leaves_its_group_x61(load: Load) -> None:
    first = '<machine name="a" address="h" default="true"/>'
    group = f'<group><machine name="b" address="h" default="true"/>{node("inside")}</group>'
    plan = load(first + node("before") + group + node("after"))
    assert machines_of_nodes(plan) == {"before": "a", "inside": "b", "after": "b"}


def test_the_same_machine_twice_x68(load: Load) -> None:
    """What stands for the same is the same; the first declaration is kept."""
    again = '<machine name="m" address="h" ssh-port="22" timeout="10" default="false" user="" env-loader=""/>'
    plan = load('<machine name="m" address="h"/>' + again)
    assert plan.machines == {"m": MachinePlan("m", "h")}
    plan = load('<machine name="m" address="h"/><machine name="m" address="h" default="true"/>' + node("n"))
    assert machines_of_nodes(plan) == {"n": "m"}


@pytest.mark.parametrize(
    "more",
    [
        'address="other"',
        'address="h" ssh-port="23"',
        'address="h" timeout="11"',
        'address="h" default="never"',
        'address="h" env-loader="/e.sh"',
        'address="h" user="me"',
        'address="h" password="x"',
    ],
)
def test_another_machine_of_the_name_is_refused_x68(load: Load, more: str) -> None:
    with pytest.raises(LaunchError, match=r"machine \[m\] has already been declared with other attributes"):
        load(f'<machine name="m" address="h"/><machine name="m" {more}/>')


@pytest.mark.parametrize(
    ("tag", "message"),
    [
        ('<machine address="h"/>', "missing required attribute: 'name'"),
        ('<machine name="" address="h"/>', "missing required attribute: 'name'"),
        ('<machine name="m"/>', "missing required attribute: 'address'"),
        ('<machine name="m" address="h" ssh-port="ssh"/>', r"'ssh-port' must be a number: \[ssh\]"),
        ('<machine name="m" address="h" timeout="soon"/>', r"'timeout' must be a number: \[soon\]"),
        ('<machine name="m" address="h" timeout=""/>', r"'timeout' must be a number: \[\]"),
        ('<machine name="m" address="h" timeout="0"/>', r"'timeout' must be a positive number: \[0\]"),
        ('<machine name="m" address="h" timeout="-1"/>', r"'timeout' must be a positive number: \[-1\]"),
        ('<machine name="m" address="h" timeout="nan"/>', r"'timeout' must be a positive number: \[nan\]"),
        ('<machine name="m" address="h" default="maybe"/>', "default must be true, false or never, not 'maybe'"),
        ('<machine name="m" address="h" ros-root="/opt"/>', "cannot have a 'ros-root' attribute; use 'env-loader'"),
        ('<machine name="m" address="h"><env name="a" value="b"/></machine>', "cannot have an <env> tag in it"),
    ],
)
def test_what_is_refused(load: Load, tag: str, message: str) -> None:
    with pytest.raises(LaunchError, match=message) as caught:
        load(tag)
    assert "main.launch" in str(caught.value), "says in which file"


def test_old_attributes_without_a_value_are_allowed(load: Load) -> None:
    assert load('<machine name="m" address="h" ros-root=""/>').machines == {"m": MachinePlan("m", "h")}
