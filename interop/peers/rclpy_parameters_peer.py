"""A ROS 2 node with parameters, written with rclpy.

`python rclpy_parameters_peer.py` is the node ``/ros2_camera``, with the same parameters as that of
`ros2_sdk_parameters_peer.py`, and those that rclpy adds. It understands the same lines, and prints the same.
"""

from __future__ import annotations

import sys
import threading
from typing import Any

import rclpy
from rcl_interfaces.msg import IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions


def check(parameters: list[Any]) -> Any:
    """Refuse even numbers; print what is set."""
    if any(each.name == "rate" and each.value % 2 == 0 for each in parameters):
        return SetParametersResult(successful=False, reason="it must be odd")
    for each in parameters:
        print("set", each.name, each.value, flush=True)
    return SetParametersResult(successful=True)


def main() -> None:
    """Run until the input ends."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("ros2_camera")
    limits = IntegerRange(from_value=1, to_value=9, step=0)
    node.declare_parameter("rate", 5, ParameterDescriptor(description="the rate", integer_range=[limits]))
    for name, value in {"gains.p": 1.5, "frame": "map", "limits": [1.0, 2.5]}.items():
        node.declare_parameter(name, value)
    node.add_on_set_parameters_callback(check)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    thread = threading.Thread(target=executor.spin, daemon=True)
    thread.start()
    print("ready", flush=True)
    for line in sys.stdin:
        node.set_parameters([Parameter(line.split()[0], value=int(line.split()[1]))])
    executor.shutdown()
    thread.join(5)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
