"""Nodes of roscpp, rospy and pyros1 on several hosts, mixed, and the addresses that a host may give itself."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

from harness import Peer
from hosts import Host

KINDS = ("roscpp", "rospy", "pyros1")
STRING = "std_msgs/String"
ADDRESSES: dict[str, tuple[dict[str, str], str | None]] = {
    "neither set": ({}, None),
    "neither set, name unknown elsewhere": ({}, ""),
    "neither set, own name is 127.0.1.1 here": ({}, "127.0.1.1"),
    "ROS_IP right": ({"ROS_IP": "ADDRESS"}, None),
    "ROS_IP right, name unknown elsewhere": ({"ROS_IP": "ADDRESS"}, ""),
    "ROS_IP of nobody": ({"ROS_IP": "10.88.0.99"}, None),
    "ROS_IP of another host": ({"ROS_IP": "10.88.0.3"}, None),
    "ROS_IP is 127.0.0.1": ({"ROS_IP": "127.0.0.1"}, None),
    "ROS_HOSTNAME right": ({"ROS_HOSTNAME": "NAME"}, None),
    "ROS_HOSTNAME unknown": ({"ROS_HOSTNAME": "nobody"}, None),
    "ROS_HOSTNAME is localhost": ({"ROS_HOSTNAME": "localhost"}, None),
    "ROS_HOSTNAME unknown, ROS_IP right": ({"ROS_HOSTNAME": "nobody", "ROS_IP": "ADDRESS"}, None),
}
"""Variables of the odd host, and the address of its name: None for the right one; empty: the other does not know it."""


def peers(host: Host, uri: str, prefix: str, **extra: str) -> list[Peer]:
    """A peer of each kind on a host, started together."""
    with ThreadPoolExecutor(len(KINDS)) as pool:
        return list(pool.map(lambda kind: host.peer(kind, f"{prefix}_{kind}", uri, **extra), KINDS))


def provide(talkers: list[Peer]) -> None:
    """Let each publish a latched message on /t_KIND, and provide /s_KIND."""
    for talker in talkers:
        talker.advertise(f"/t_{talker.kind}", STRING, latch=True)
        talker.publish(f"/t_{talker.kind}")
        talker.serve(f"/s_{talker.kind}", "std_srvs/SetBool")


def check_served(listener: Peer) -> None:
    """Check that a peer gets the messages and answers of all kinds."""
    for kind in KINDS:
        listener.subscribe(f"/t_{kind}", STRING)
        listener.received(f"/t_{kind}", timeout=40)
        listener.call(f"/s_{kind}", "std_srvs/SetBool")
