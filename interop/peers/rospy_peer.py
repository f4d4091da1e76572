#!/usr/bin/python3
"""The stock rospy peer of the interop tests: ``rospy_peer.py NODE_NAME [remappings]``."""

from __future__ import annotations

import sys
import xmlrpc.client
from typing import Any

import genpy
import roslib.message
import rospy
from peer_core import UNSET, Backend, Peer, read_commands
from samples import Samples


def message_class(type_name: str) -> Any:
    return rospy.AnyMsg if type_name == "*" else roslib.message.get_message_class(type_name)


class RospyBackend(Backend):
    """Stock rospy behind the peer's commands."""

    def __init__(self) -> None:
        self.samples = Samples(lambda name: message_class(name)(), genpy.Time, genpy.Duration)

    def advertise(self, topic: str, type_name: str, queue_size: int, latch: bool) -> Any:
        return rospy.Publisher(topic, message_class(type_name), queue_size=queue_size or None, latch=latch)

    def subscribe(self, topic: str, type_name: str, queue_size: int, callback: Any) -> Any:
        return rospy.Subscriber(
            topic, message_class(type_name), callback, queue_size=queue_size or None, tcp_nodelay=True, buff_size=2**20
        )

    def links(self, endpoint: Any) -> int:
        return int(endpoint.get_num_connections())

    def serve(self, name: str, type_name: str, handler: Any) -> Any:
        return rospy.Service(name, roslib.message.get_service_class(type_name), handler)

    def unserve(self, server: Any) -> None:
        server.shutdown()

    def new_request(self, type_name: str) -> Any:
        return roslib.message.get_service_class(type_name)._request_class()

    def new_response(self, type_name: str) -> Any:
        return roslib.message.get_service_class(type_name)._response_class()

    def client(self, name: str, type_name: str, persistent: bool) -> Any:
        return rospy.ServiceProxy(name, roslib.message.get_service_class(type_name), persistent=persistent)

    def available(self, name: str, timeout: float) -> bool:
        try:
            rospy.wait_for_service(name, timeout)
        except rospy.ROSException:
            return False
        return True

    def set_param(self, key: str, value: Any) -> None:
        rospy.set_param(key, xmlrpc.client.Binary(value) if isinstance(value, bytes) else value)

    def get_param(self, key: str) -> Any:
        value = rospy.get_param(key, UNSET)
        return value.data if isinstance(value, xmlrpc.client.Binary) else value

    def cached_param(self, key: str) -> Any:
        try:
            return rospy.get_param_cached(key)
        except KeyError:
            return UNSET

    def has_param(self, key: str) -> bool:
        return bool(rospy.has_param(key))

    def delete_param(self, key: str) -> bool:
        try:
            rospy.delete_param(key)
        except KeyError:
            return False
        return True

    def search_param(self, key: str) -> Any:
        return rospy.search_param(key)

    def log(self, level: str, text: str) -> None:
        getattr(rospy, "logerr" if level == "error" else "log" + level)(text)

    def close(self) -> None:
        rospy.signal_shutdown("done")


def main() -> None:
    rospy.init_node(sys.argv[1])
    commands = read_commands()
    rospy.on_shutdown(lambda: commands.put(None))
    Peer(RospyBackend()).run(rospy.get_name(), commands)


if __name__ == "__main__":
    main()
