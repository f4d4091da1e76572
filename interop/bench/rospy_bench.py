#!/usr/bin/python3
"""The rospy side of the benchmarks: ``rospy_bench.py ROLE KEY=VALUE ...``; see roles.py.

Needs nothing but modules that answer to ``import rospy`` and to the messages' names.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

import rospy
from roles import play

BUFFER = 2**24  # with a smaller one, rospy's bounded queue keeps nothing but the newest image of each 64 KiB


class Rospy:
    """rospy as the roles want a library."""

    spin, now, rate = staticmethod(rospy.spin), staticmethod(rospy.Time.now), rospy.Rate

    def load(self, type_name: str) -> Any:
        package, _, name = type_name.partition("/")
        return getattr(importlib.import_module(package + ".msg"), name)

    def load_service(self, type_name: str) -> Any:
        package, _, name = type_name.partition("/")
        return getattr(importlib.import_module(package + ".srv"), name)

    def start(self, name: str) -> None:
        rospy.init_node(name, anonymous=True)

    def ok(self) -> bool:
        return not rospy.is_shutdown()

    def advertise(self, topic: str, message_class: Any, queue: int | None, latch: bool = False) -> Any:
        return rospy.Publisher(topic, message_class, queue_size=queue, latch=latch, tcp_nodelay=True)

    def subscribe(self, topic: str, message_class: Any, callback: Callable[[Any], Any], queue: int | None) -> Any:
        large = "data" in message_class.__slots__ and "header" in message_class.__slots__
        size = {"buff_size": BUFFER} if large else {}
        return rospy.Subscriber(topic, message_class, callback, queue_size=queue, tcp_nodelay=True, **size)

    def connections(self, handle: Any) -> int:
        return int(handle.get_num_connections())

    def transforms(self) -> Any:
        tf2_ros = importlib.import_module("tf2_ros")
        buffer = tf2_ros.Buffer()
        self.listener = tf2_ros.TransformListener(buffer, tcp_nodelay=True)
        return buffer

    def serve(self, name: str, service_class: Any, handler: Callable[[Any], Any]) -> Any:
        return rospy.Service(name, service_class, handler)

    def client(self, name: str, service_class: Any, persistent: bool) -> Callable[..., Any]:
        rospy.wait_for_service(name)
        client: Callable[..., Any] = rospy.ServiceProxy(name, service_class, persistent=persistent)
        return client


if __name__ == "__main__":
    play(Rospy())
