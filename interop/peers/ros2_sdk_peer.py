"""A ROS 2 program, written with zenoh-ros2-sdk, which speaks rmw_zenoh's protocol by itself.

`python ros2_sdk_peer.py PORT` publishes ``from ROS 2 1``, ``from ROS 2 2`` and so on on ``/from_ros2``, five times per
second, prints what it gets on ``/from_ros1`` and the latched ``/map_name``, and offers the service ``/ros2_switch``.
For an empty line of its input, it prints the names of all topics; for ``call true`` or ``call false``, what
``/ros1_switch`` responds, or that it does not, and after how many seconds. It ends with its input.
"""

from __future__ import annotations

import sys
import threading
import time

import zenoh_ros2_sdk as sdk
from zenoh_ros2_sdk.qos import QosDurability, QosProfile

STRING, TEXT = "std_msgs/msg/String", "string data\n"
SET_BOOL = "std_srvs/srv/SetBool"
PARTS = {"request_definition": "bool data\n", "response_definition": "bool success\nstring message\n"}


def main() -> None:
    """Run until the input ends."""
    router = {"router_ip": "127.0.0.1", "router_port": int(sys.argv[1])}
    latched = QosProfile(durability=QosDurability.TRANSIENT_LOCAL, history_depth=1)
    talker = sdk.ROS2Publisher("/from_ros2", STRING, msg_definition=TEXT, node_name="sdk_talker", **router)
    ends = [
        talker,
        sdk.ROS2Subscriber(
            "/from_ros1",
            STRING,
            lambda message: print("got", message.data, flush=True),
            msg_definition=TEXT,
            node_name="sdk_listener",
            **router,
        ),
        sdk.ROS2Subscriber(
            "/map_name",
            STRING,
            lambda message: print("latched", message.data, flush=True),
            msg_definition=TEXT,
            node_name="sdk_map",
            qos=latched,
            **router,
        ),
    ]
    server = sdk.ROS2ServiceServer(
        "/ros2_switch",
        SET_BOOL,
        lambda request: server.response_msg_class(success=request.data, message="switched by ROS 2"),
        node_name="sdk_server",
        **PARTS,
        **router,
    )
    client = sdk.ROS2ServiceClient("/ros1_switch", SET_BOOL, node_name="sdk_client", timeout=10.0, **PARTS, **router)
    ends += [server, client]
    ended = threading.Event()

    def talk() -> None:
        number = 0
        while not ended.wait(0.2):
            number += 1
            talker.publish(data=f"from ROS 2 {number}")

    thread = threading.Thread(target=talk)
    thread.start()
    print("ready", flush=True)
    for line in sys.stdin:
        if line.startswith("call "):
            call(client, line == "call true\n")
            continue
        print("topics", *sorted(str(topic) for topic in sdk.get_topic_names_and_types(**router)), flush=True)
    ended.set()
    thread.join()
    for end in ends:
        end.close()


def call(client: sdk.ROS2ServiceClient, data: bool) -> None:
    """Call a service, and print what comes."""
    begin = time.monotonic()
    response = client.call(data=data)
    if response is None:
        print(f"no response after {time.monotonic() - begin:.1f} s", flush=True)
    else:
        print("response", response.success, response.message, flush=True)


if __name__ == "__main__":
    main()
