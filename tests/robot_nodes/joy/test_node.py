"""joy_node, with a pipe for a joystick."""

from __future__ import annotations

import struct
from collections.abc import Callable
from queue import Queue
from typing import Any

import pytest

from pyros1.msgs.diagnostic_msgs.msg import DiagnosticArray
from pyros1.msgs.sensor_msgs.msg import Joy
from pyros1.robot_nodes.joy.device import Device
from pyros1.robot_nodes.joy.joystick import Settings
from pyros1.robot_nodes.joy.node import JoyNode, read_settings
from pyros1.robot_nodes.shared.parameters import PrivateParameters

Make = Callable[..., Any]
BUTTON, AXIS, INIT = 1, 2, 128


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({}, Settings(0.05, 0.0, 0.001, False, False)),
        ({"deadzone": 0.95, "autorepeat_rate": 20}, Settings(0.9, 20.0)),
        ({"deadzone": 32767, "coalesce_interval": 0}, Settings(0.9, 0.0, 0.0)),
        ({"deadzone": 2.0}, Settings(2 / 32767)),
        ({"default_trig_val": True, "sticky_buttons": True}, Settings(0.05, 0.0, 0.001, True, True)),
        ({"deadzone": -1, "autorepeat_rate": -1, "coalesce_interval": "fast", "sticky_buttons": 1}, Settings()),
    ],
)
def test_parameters(values: dict[str, Any], expected: Settings) -> None:
    assert read_settings(PrivateParameters(values, lambda text: None)) == expected


def test_plugging_in_and_unplugging(
    make_node: Make, joystick: Any, next_of: Callable[..., Any], capfd: pytest.CaptureFixture[str]
) -> None:
    """Feature: joy_node opens a joystick again, and lets go of everything when it is gone"""
    came: Queue[Any] = Queue()
    statuses: Queue[Any] = Queue()
    user = make_node("user")
    joy = user.subscribe("joy", Joy, came.put)
    user.subscribe("/diagnostics", DiagnosticArray, lambda array: statuses.put(array.status[0]))
    node = make_node("stick", argv=[f"_dev:={joystick.path}", "_diagnostic_period:=0.05"])
    JoyNode(node)
    status = next_of(statuses, lambda status: status.level == 2)
    assert (status.name, status.message) == ("stick: Joystick Driver Status", "Joystick not open.")
    assert joy.wait_for_publishers(timeout=20)
    for _ in range(2):
        joystick.plug()
        joystick.send(INIT | BUTTON, 1, 0)
        joystick.send(BUTTON, 0, 1)
        joystick.send(AXIS, 1, -32767)
        message = next_of(came, lambda joy: 1.0 in joy.axes)
        assert (message.header.frame_id, message.axes, message.buttons) == (joystick.path, (0.0, 1.0), (1, 0))
        assert message.header.stamp.secs > 0
        status = next_of(statuses, lambda status: status.level == 0 and status.message == "OK")
        assert {value.key: value.value for value in status.values}["device"] == joystick.path
        joystick.unplug()
        message = next_of(came, lambda joy: 1.0 not in joy.axes)
        assert (message.axes, message.buttons) == ((0.0, 0.0), (0, 0))
    joystick.plug()
    joystick.send(BUTTON, 0, 1)
    next_of(came, lambda joy: joy.buttons[0])
    node.shutdown()
    assert next_of(came, lambda joy: True).buttons == (0,), "the end of the node stops the robot, too"
    lines = [line for line in capfd.readouterr().err.splitlines() if "again" in line]
    assert [line.partition(": ")[2] for line in lines] == [
        f"cannot open the joystick {joystick.path} (No such file or directory); trying again every second",
        *2 * [f"lost the joystick {joystick.path} (it was closed); trying again every second"],
    ]


def test_each_press_and_release_is_a_message(make_node: Make, joystick: Any) -> None:
    came: Queue[Any] = Queue()
    user = make_node("user")
    # In the publisher's thread, since a message may replace one that waits.
    subscriber = user.subscribe("joy", Joy, lambda joy: came.put(joy.buttons), in_publisher=True)
    JoyNode(make_node("stick", argv=[f"_dev:={joystick.path}"]))
    assert subscriber.wait_for_publishers(timeout=20)
    joystick.plug()
    joystick.write(3 * (struct.pack("=IhBB", 0, 1, BUTTON, 0) + struct.pack("=IhBB", 0, 0, BUTTON, 0)))
    assert [came.get(timeout=20) for _ in range(6)] == 3 * [(1,), (0,)]


def test_what_is_no_joystick(
    make_node: Make, joystick: Any, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []

    def open_device(path: str) -> Device:
        opened.append(path)
        return Device(path)

    monkeypatch.setattr("pyros1.robot_nodes.joy.node.Device", open_device)
    monkeypatch.setattr("pyros1.robot_nodes.joy.node.RETRY_PERIOD", 60.0)
    statuses: Queue[Any] = Queue()
    user = make_node("user")
    user.subscribe("/diagnostics", DiagnosticArray, lambda array: statuses.put(array.status[0]))
    joystick.plug()
    joystick.send(7, 0, 0)
    JoyNode(make_node("stick", argv=[f"_dev:={joystick.path}", "_diagnostic_period:=0.05"]))
    for _ in range(2):
        while not any(value.key == "problem" for value in statuses.get(timeout=20).values):
            pass
    assert capfd.readouterr().err.count("it sent an event of unknown type 7: it is no joystick") == 1
    assert opened == [joystick.path], "it is not opened again at once"


def test_a_node_that_shuts_down_while_it_starts(make_node: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    node = make_node("joy_node")
    ended: list[bool] = []

    def call_now(hook: Callable[[], object], early: bool = False) -> None:
        hook()
        ended.append(early)

    monkeypatch.setattr(node, "on_shutdown", call_now)
    JoyNode(node)
    assert ended == [False]
