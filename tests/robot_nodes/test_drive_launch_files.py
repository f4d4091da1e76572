"""The launch files that come with the packages from joystick to cmd_vel, which those of robots include."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pyros1.finding.packages import OWN_PACKAGES, PackageIndex
from pyros1.launch.plan import Plan
from pyros1.launch.reading.loader import load_plan
from pyros1.launch.reading.resources import Resources
from pyros1.robot_nodes.interactive_marker_twist_server.handle import read_settings
from pyros1.robot_nodes.joy.node import read_settings as read_joy_settings
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.twist_sources import read_sources
from pyros1.robot_nodes.teleop_twist_joy.teleop import read_controls
from pyros1.robot_nodes.twist_mux.turbo import read_ranges
from pyros1.robot_nodes.yocs_cmd_vel_mux.config import read_config
from pyros1.robot_nodes.yocs_velocity_smoother.node import check_limits

PACKAGES = Path(OWN_PACKAGES)


def load(file: str, **arguments: str) -> Plan:
    """Return the plan of a launch file, all of whose programs there are."""
    index = PackageIndex({}, installs=[])
    plan = load_plan([str(PACKAGES / file)], arguments, Resources(index, {}))
    assert plan.warnings == []
    for node in plan.nodes:
        assert index.find_executable(node.package, node.type), node.type
    return plan


def private(plan: Plan, name: str) -> PrivateParameters:
    """Return the private parameters of a node; no value may be rejected."""
    tree: dict[str, Any] = {}
    for key, value in plan.params.items():
        if key.startswith(f"/{name}/"):
            *path, last = key.split("/")[2:]
            branch = tree
            for part in path:
                branch = branch.setdefault(part, {})
            branch[last] = value
    return PrivateParameters(tree, pytest.fail)


@pytest.mark.parametrize("config", ["ps3", "ps3-holonomic", "ps4", "xbox", "atk3", "xd3"])
def test_teleop(config: str) -> None:
    plan = load("teleop_twist_joy/launch/teleop.launch", joy_config=config, joy_dev="/dev/input/js3")
    controls = read_controls(private(plan, "teleop_twist_joy"))
    assert controls.enable_button >= 0 and len({controls.enable_button, controls.turbo_button}) == 2
    assert [axis.scale > 0 for axis in controls.axes] == [True] * (3 if config == "ps3-holonomic" else 2)
    settings = read_joy_settings(private(plan, "joy_node"))
    assert (settings.deadzone, settings.autorepeat_rate) == (0.3, 20.0)
    assert plan.params["/joy_node/dev"] == "/dev/input/js3"


def test_teleop_with_another_file() -> None:
    other = str(PACKAGES / "teleop_twist_joy" / "config" / "atk3.config.yaml")
    plan = load("teleop_twist_joy/launch/teleop.launch", config_filepath=other)
    assert read_controls(private(plan, "teleop_twist_joy")).turbo_button == 1


@pytest.mark.parametrize(("config", "axes"), [("linear", "x"), ("planar", "xy"), ("aerial", "xyz")])
def test_marker(config: str, axes: str) -> None:
    plan = load("interactive_marker_twist_server/launch/interactive_markers.launch", config=config)
    settings = read_settings(private(plan, "twist_marker_server"))
    assert [*settings.linear] == [*axes] and all(scale.speed(-0.5) == -0.5 for scale in settings.linear.values())


def test_twist_mux() -> None:
    plan = load("twist_mux/launch/twist_mux.launch", cmd_vel_out="base/cmd_vel")
    values = private(plan, "twist_mux")
    topics = {source.name: source.topic for source in read_sources(values.value("topics"), "topics", 255)}
    assert topics["joystick"] == "joy_vel" and len(read_sources(values.value("locks"), "locks", 255)) == 3
    remappings = {node.type: dict(node.remappings) for node in plan.nodes}
    assert remappings["twist_mux"]["cmd_vel_out"] == remappings["twist_marker"]["twist"] == "base/cmd_vel"
    assert read_ranges(private(plan, "joystick_relay")).initial_step == 2


def test_yujin() -> None:
    plan = load("yocs_velocity_smoother/launch/velocity_smoother.launch", node_name="slow", odom_topic="/odom")
    check_limits(private(plan, "slow"), "/slow")
    [node] = plan.nodes
    assert (node.name, dict(node.remappings)["slow/odometry"]) == ("slow", "/odom")
    plan = load("yocs_cmd_vel_mux/launch/cmd_vel_mux.launch")
    file = Path(plan.params["/yocs_cmd_vel_mux/yaml_cfg_file"])
    assert read_config(file.read_text(), file.name).output == "output/cmd_vel"
