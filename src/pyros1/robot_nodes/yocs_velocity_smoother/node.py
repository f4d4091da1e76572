"""velocity_smoother: passes ~raw_cmd_vel on to ~smooth_cmd_vel within the limits of the robot.

It replaces the nodelet yocs_velocity_smoother/VelocitySmootherNodelet (https://wiki.ros.org/yocs_velocity_smoother).
Commands and velocities that are not finite are dropped.
"""

from __future__ import annotations

import threading
from typing import Any

from pyros1.ground.errors import SettingError
from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.nav_msgs.msg import Odometry
from pyros1.node import Node
from pyros1.reconfigure import Parameters, Server
from pyros1.robot_nodes.shared.node_clock import NodeClock, check_regularly
from pyros1.robot_nodes.shared.parameters import PrivateParameters, is_number
from pyros1.robot_nodes.shared.program import run_node
from pyros1.robot_nodes.shared.twists import TwistOutput, is_finite
from pyros1.robot_nodes.yocs_velocity_smoother.smoother import STANDSTILL, Feedback, Limits, Smoother, Velocity

CHECK_PERIOD = 0.1
"""Seconds between checks of whether simulated time stands still."""
_MANDATORY = ("speed_lim_v", "speed_lim_w", "accel_lim_v", "accel_lim_w")
_MAX_LIMIT = 10.0
_MIN_FREQUENCY, _MAX_FREQUENCY = 1.0, 1000.0


def describe_parameters() -> Parameters:
    """Return the parameters that other nodes can change while the node is running."""
    parameters = Parameters()
    for name, default, description in (
        ("speed_lim_v", 1.0, "Maximum forward speed in m/s"),
        ("speed_lim_w", 5.0, "Maximum turning speed in rad/s"),
        ("accel_lim_v", 0.5, "Maximum forward acceleration in m/s²"),
        ("accel_lim_w", 2.5, "Maximum angular acceleration in rad/s²"),
        ("decel_factor", 1.0, "Maximum deceleration as a multiple of the acceleration"),
    ):
        parameters.add(name, default, description, minimum=0.0, maximum=_MAX_LIMIT)
    return parameters


def check_limits(values: PrivateParameters, name: str) -> None:
    """Check the mandatory parameters.

    Args:
        values: the parameters.
        name: the node's name.

    Raises:
        SettingError: parameters are not set, or cannot be used.
    """
    missing = [limit for limit in _MANDATORY if values.value(limit) is None]
    if missing:
        raise SettingError(f"{name} needs the parameters {', '.join(missing)}: limits in m/s, rad/s, m/s² and rad/s²")
    for limit in _MANDATORY:
        value = values.value(limit)
        if not is_number(value) or value < 0:
            raise SettingError(f"the parameter {name}/{limit} must be a number of at least 0, not {value!r}")


class VelocitySmoother:
    """Publishes a command within the limits, at a constant rate while there is input and until the robot stands still.

    Args:
        node: the node.

    Raises:
        SettingError: mandatory parameters are not set, or cannot be used.
    """

    def __init__(self, node: Node) -> None:
        values = PrivateParameters.of(node)
        check_limits(values, node.name)
        node.params["~decel_factor"] = values.number("decel_factor", 1.0, 0.0, _MAX_LIMIT)
        frequency = values.number("frequency", 20.0, _MIN_FREQUENCY, _MAX_FREQUENCY)
        feedback = Feedback(values.integer("robot_feedback", 0, min(Feedback), max(Feedback)))
        self._node = node
        self._clock = NodeClock(node)
        self._lock = threading.Lock()
        self._smoother = Smoother(Limits(STANDSTILL, STANDSTILL), 1 / frequency, feedback)
        self._server = Server(node, describe_parameters(), self._configure)
        self._output = TwistOutput(node, "~smooth_cmd_vel")
        node.subscribe("~raw_cmd_vel", Twist, self._command, queue_size=1)
        if feedback == Feedback.ODOMETRY:
            node.subscribe("~odometry", Odometry, lambda odometry: self._observe(odometry.twist.twist), queue_size=1)
        elif feedback == Feedback.COMMANDS:
            node.subscribe("~robot_cmd_vel", Twist, self._observe, queue_size=1)
        node.timer(1 / frequency, lambda event: self._step())
        if node.simulated_time:
            check_regularly(node, CHECK_PERIOD, self._check_clock)

    def _configure(self, config: Any, level: int) -> Any:
        speed = Velocity(config.speed_lim_v, config.speed_lim_w)
        acceleration = Velocity(config.accel_lim_v, config.accel_lim_w)
        with self._lock:
            self._smoother.limits = Limits(speed, acceleration, config.decel_factor)
        return config

    def _command(self, twist: Any) -> None:
        if not is_finite(twist):
            self._node.log.error("dropped a command, since it is not finite", throttle=10)
            return
        with self._lock:
            self._smoother.command(Velocity(twist.linear.x, twist.angular.z), self._clock.seconds())

    def _observe(self, twist: Any) -> None:
        if is_finite(twist):
            with self._lock:
                self._smoother.robot_moves(Velocity(twist.linear.x, twist.angular.z), self._clock.seconds())

    def _check_clock(self) -> None:
        """Stop the robot if simulated time stands still, since no more steps are made then."""
        with self._lock:
            if self._clock.stands_still() and self._output.stop():
                self._smoother.on_stopped()
                self._node.log.error("stopped the robot, since /clock has stopped")

    def _step(self) -> None:
        with self._lock:
            velocity = self._smoother.step(self._clock.seconds())
        if velocity is not None:
            twist = Twist()
            twist.linear.x, twist.angular.z = velocity
            self._output.publish(twist)


def main(argv: list[str]) -> int:
    """Run velocity_smoother; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "velocity_smoother", VelocitySmoother)
