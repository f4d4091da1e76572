"""joystick_relay.py: scales a joystick's commands, and publishes whether the joystick has priority.

Commands from -1 to 1 on joy_vel_in become speeds on joy_vel_out. joy_priority, a lock of twist_mux, is true while the
joystick drives the robot. The actions joy_priority_action, joy_turbo_increase and others change the priority and the
speeds. See https://wiki.ros.org/twist_mux.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from pyros1.actions import Server
from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.std_msgs.msg import Bool
from pyros1.msgs.visualization_msgs.msg import Marker
from pyros1.node import Node
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.program import run_node
from pyros1.robot_nodes.shared.twists import TwistOutput
from pyros1.robot_nodes.twist_mux.turbo import Turbo, read_ranges


class JoystickRelay:
    """Passes commands on while the joystick has priority.

    Args:
        node: the node.
    """

    def __init__(self, node: Node) -> None:
        values = PrivateParameters.of(node)
        self._node = node
        self._has_priority = values.flag("priority", True)
        self._turbo = turbo = Turbo(read_ranges(values))
        self._lock = threading.Lock()
        self._output = TwistOutput(node, "joy_vel_out")
        self._priority = node.advertise("joy_priority", Bool, queue_size=1, latch=True)
        self._marker = node.advertise("text_marker", Marker, queue_size=1, latch=True)
        self._announce()
        node.subscribe("joy_vel_in", Twist, self._relay, queue_size=1)
        self._serve("joy_priority_action", "JoyPriority", self._toggle)
        for name, do in (
            ("increase", lambda: turbo.change(1)),
            ("decrease", lambda: turbo.change(-1)),
            ("angular_increase", lambda: turbo.change_turning(1)),
            ("angular_decrease", lambda: turbo.change_turning(-1)),
            ("reset", turbo.reset),
        ):
            self._serve(f"joy_turbo_{name}", "JoyTurbo", do)

    def _serve(self, name: str, action: str, do: Callable[[], object]) -> None:
        def execute(goal: Any) -> None:
            goal.accept()
            with self._lock:
                do()
            goal.succeed()

        Server(self._node, name, f"twist_mux_msgs/{action}", execute)

    def _relay(self, command: Any) -> None:
        with self._lock:
            if not self._has_priority:
                return
            twist = self._turbo.scale(command)
            if twist is None:
                self._node.log.error("ignored a command: it must be from -1 to 1, for x, y and turning", throttle=10)
            self._output.publish(Twist() if twist is None else twist)

    def _toggle(self) -> None:
        self._has_priority = not self._has_priority
        self._node.log.info("the joystick %s", "drives the robot" if self._has_priority else "has no priority")
        self._output.publish(Twist())
        self._announce()

    def _announce(self) -> None:
        self._priority.publish(self._has_priority)
        marker = Marker(type=Marker.TEXT_VIEW_FACING, text="Manual" if self._has_priority else "Autonomous")
        marker.header.frame_id = "base_footprint"
        marker.pose.position.z, marker.pose.orientation.w, marker.scale.z = 2.0, 1.0, 0.5
        marker.color.r = marker.color.g = marker.color.b = marker.color.a = 1.0
        self._marker.publish(marker)


def main(argv: list[str]) -> int:
    """Run joystick_relay.py; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "joystick_relay", JoystickRelay)
