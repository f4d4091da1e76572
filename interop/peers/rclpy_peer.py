"""A ROS 2 program, written with rclpy.

`python rclpy_peer.py` publishes ``from ROS 2 1``, ``from ROS 2 2`` and so on on ``/from_ros2``, five times per second,
and ``from ROS 2`` on ``/both``. Two of its nodes have each published a latched message on ``/ros2_places``. It prints
what it gets on ``/from_ros1``, ``/both`` and the latched ``/map_name``, and offers the service ``/ros2_switch``. For an
empty line of its input, it prints the names of all topics; for ``call true`` or ``call false``, what ``/ros1_switch``
responds, or that it does not, and after how many seconds. It ends with its input.
"""

from __future__ import annotations

import sys
import threading
import time
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import String
from std_srvs.srv import SetBool

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
CALL_TIME = 10.0


def make_node(name: str) -> Any:
    """Return a node with publishers, subscribers and a service."""
    node = rclpy.create_node(name)
    for topic, word, qos in (("/from_ros1", "got", 10), ("/map_name", "latched", LATCHED), ("/both", "both", 10)):
        node.create_subscription(String, topic, lambda message, word=word: print(word, message.data, flush=True), qos)
    talker, both = node.create_publisher(String, "/from_ros2", 10), node.create_publisher(String, "/both", 10)
    numbers = iter(range(1, sys.maxsize))

    def talk() -> None:
        talker.publish(String(data=f"from ROS 2 {next(numbers)}"))
        both.publish(String(data="from ROS 2"))

    node.create_timer(0.2, talk)
    node.create_service(SetBool, "/ros2_switch", switch)
    return node


def make_place(name: str) -> Any:
    """Return a node that has published a latched message."""
    node = rclpy.create_node(f"place_{name}")
    node.create_publisher(String, "/ros2_places", LATCHED).publish(String(data=name))
    return node


def switch(request: Any, response: Any) -> Any:
    """Respond to a call."""
    response.success, response.message = request.data, "switched by ROS 2"
    return response


def call(client: Any, data: bool) -> None:
    """Call a service, and print what comes."""
    begin = time.monotonic()
    client.wait_for_service(CALL_TIME)
    future, done = client.call_async(SetBool.Request(data=data)), threading.Event()
    future.add_done_callback(lambda _: done.set())
    if done.wait(CALL_TIME):
        response = future.result()
        print("response", response.success, response.message, flush=True)
    else:
        print(f"no response after {time.monotonic() - begin:.1f} s", flush=True)


def main() -> None:
    """Run until the input ends."""
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = make_node("rclpy_peer")
    others = [make_place("yard"), make_place("cellar")]
    client = node.create_client(SetBool, "/ros1_switch")
    executor = SingleThreadedExecutor()
    for each in (node, *others):
        executor.add_node(each)
    thread = threading.Thread(target=executor.spin, daemon=True)
    thread.start()
    print("ready", flush=True)
    try:
        for line in sys.stdin:
            if line.startswith("call "):
                call(client, line == "call true\n")
            else:
                print("topics", *sorted(name for name, _ in node.get_topic_names_and_types()), flush=True)
    except KeyboardInterrupt:
        pass
    executor.shutdown()
    thread.join(2)
    for each in (node, *others):
        each.destroy_node()  # so that others need not wait until they notice
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
