"""joy_remap.py as a node."""

from __future__ import annotations

from collections.abc import Callable
from queue import Queue
from typing import Any

import pytest

from pyros1.msgs.sensor_msgs.msg import Joy
from pyros1.robot_nodes.joy.remap_node import JoyRemap, main

Make = Callable[..., Any]


def test_messages_are_converted_and_the_buttons_released_at_the_end(make_node: Make, transport: str) -> None:
    user = make_node("user")
    user.params["/remap/mappings"] = {"axes": ["-axes[1]", 1.0], "buttons": ["axes[0]", "buttons[0]"]}
    came: Queue[Any] = Queue()
    remapped = user.subscribe("joy", Joy, came.put)
    JoyRemap(make_node("remap", argv=["joy_in:=joy_orig", "joy_out:=joy"]))
    assert remapped.wait_for_publishers(1, 20)
    driver = make_node("driver")
    joystick = driver.advertise("joy_orig", Joy, latch=True)
    message = Joy(axes=[-0.5, 0.25], buttons=[1])
    message.header.frame_id = "/dev/input/js0"
    joystick.publish(message)
    joy = came.get(timeout=20)
    assert (list(joy.axes), list(joy.buttons), joy.header.frame_id) == ([-0.25, 1.0], [0, 1], "/dev/input/js0")
    driver.shutdown()
    joy = came.get(timeout=20)
    assert (list(joy.axes), list(joy.buttons), joy.header.frame_id) == ([0.0, 0.0], [0, 0], "/dev/input/js0")


def test_a_malformed_mapping_is_said(make_node: Make, capfd: pytest.CaptureFixture[str]) -> None:
    user = make_node("user")
    user.params["/joy_remap/mappings"] = {"axes": ["axes[0"]}
    assert main(["joy_remap.py", f"__master:={user.master_uri}"]) == 1
    assert "~mappings/axes: [axes[0]" in capfd.readouterr().err
