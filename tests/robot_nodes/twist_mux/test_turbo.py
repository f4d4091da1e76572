"""Speeds in steps, and the relay."""

from __future__ import annotations

from collections.abc import Callable
from math import nan
from queue import Queue
from typing import Any

import pytest

from pyros1.actions import Client
from pyros1.msgs.geometry_msgs.msg import Twist, Vector3
from pyros1.msgs.std_msgs.msg import Bool
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.twists import components
from pyros1.robot_nodes.twist_mux.relay import JoystickRelay
from pyros1.robot_nodes.twist_mux.turbo import Turbo, read_ranges

TURBO = {"linear_forward_min": 0.5, "linear_forward_max": 2.0, "linear_backward_min": 0.25, "steps": 4}
TURBO |= {"linear_backward_max": 0.25, "angular_min": 1.0, "angular_max": 4.0}


def command(x: float = 0.0, y: float = 0.0, yaw: float = 0.0, other: float = 0.0) -> Any:
    return Twist(Vector3(x, y, other), Vector3(0.0, 0.0, yaw))


def turbo(**values: Any) -> Turbo:
    return Turbo(read_ranges(PrivateParameters({"turbo": values}, pytest.fail)))


def test_steps() -> None:
    machine = turbo(**TURBO)
    scaled = []
    for change in (0, 5, -1, -9, 0):
        machine.change(change)
        scaled.append(components(machine.scale(command(1.0, 1.0, -0.5))))
    assert [(x, y, yaw) for x, y, _, _, _, yaw in scaled] == [
        (1.0, 1.0, -1.0),
        (2.0, 1.0, -2.0),
        (1.5, 1.0, -1.5),
        (0.5, 1.0, -0.5),
        (0.5, 1.0, -0.5),
    ]
    assert machine.scale(command(-0.5)).linear.x == -0.125
    machine.change_turning(1)
    assert components(machine.scale(command(1.0, 0.0, 1.0)))[::5] == (0.5, 2.0)
    machine.reset()
    assert components(machine.scale(command(1.0, 0.0, 1.0)))[::5] == (1.0, 2.0)


def test_defaults() -> None:
    assert components(turbo().scale(command(-1.0, 0.5, 0.25))) == (-1.0, 0.5, 0, 0, 0, 0.25)
    assert turbo(**TURBO, init_step=4).scale(command(1.0)).linear.x == 2.0


@pytest.mark.parametrize("bad", [command(1.1), command(y=-1.1), command(yaw=2.0), command(other=0.1), command(nan)])
def test_what_is_no_command_of_a_joystick(bad: Any) -> None:
    assert turbo().scale(bad) is None


def test_relay(make_node: Callable[..., Any], next_of: Callable[..., Any]) -> None:
    user = make_node("user")
    user.params["/joystick_relay/turbo"] = TURBO
    came: Queue[Any] = Queue()
    priorities: Queue[Any] = Queue()
    commands = user.subscribe("joy_vel_out", Twist, lambda twist: came.put(twist.linear.x))
    user.subscribe("joy_priority", Bool, lambda message: priorities.put(message.data))
    JoystickRelay(make_node("joystick_relay"))
    stick = user.advertise("joy_vel_in", Twist)
    assert commands.wait_for_publishers(1, 20) and stick.wait_for_subscribers(timeout=20)

    def act(name: str, kind: str) -> None:
        with Client(user, name, f"twist_mux_msgs/{kind}") as client:
            client.send(client.types.goal()).result(timeout=20)

    stick.publish(command(1.0))
    assert (priorities.get(timeout=20), came.get(timeout=20)) == (True, 1.0)
    act("joy_turbo_increase", "JoyTurbo")
    stick.publish(command(1.0))
    assert came.get(timeout=20) == 1.5
    act("joy_priority_action", "JoyPriority")
    assert (priorities.get(timeout=20), came.get(timeout=20)) == (False, 0.0)
    stick.publish(command(1.0))
    act("joy_priority_action", "JoyPriority")
    assert (priorities.get(timeout=20), came.get(timeout=20)) == (True, 0.0)
    stick.publish(command(9.0))
    next_of(came, lambda speed: speed == 0.0)
    stick.publish(command(-1.0))
    next_of(came, lambda speed: speed == -0.25)
