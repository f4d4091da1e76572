"""Queries for the type of a topic, which are connections of their own."""

from __future__ import annotations

from queue import Queue
from typing import Any

from harness import STOCK_PYTHON, Master, Process

from pyros1.doctor.probe import query_publisher
from pyros1.node import Node

MASTERS = ("stock",)
PUBLISHER = """
import rospy
from std_msgs.msg import Int32
rospy.init_node("talker")
publisher = rospy.Publisher("/numbers", Int32, queue_size=10)
rate = rospy.Rate(50)
number = 0
while not rospy.is_shutdown():
    publisher.publish(number)
    number += 1
    rate.sleep()
"""


def test_a_node_that_queries_keeps_its_subscription(launcher: Master) -> None:
    """rospy closes all connections of a node when one of them ends, within half a second."""
    launcher.processes.append(Process((STOCK_PYTHON, "-c", PUBLISHER), launcher.environ("stock"), "talker"))
    with Node("listener", argv=[], environ=launcher.environ("ours"), handle_signals=False) as node:
        numbers: Queue[Any] = Queue()
        subscriber = node.subscribe("/numbers", "std_msgs/Int32", lambda message: numbers.put(message.data))
        assert subscriber.wait_for_publishers(1, 20)
        first = numbers.get(timeout=20)
        reported = query_publisher(node.name, node.master.lookup_node("/talker"), "/numbers")
        assert reported.type == "std_msgs/Int32"
        assert [numbers.get(timeout=20) for _ in range(75)] == [*range(first + 1, first + 76)]
