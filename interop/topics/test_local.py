"""The local transport beside stock's nodes, which notice nothing of it: they are linked over TCP, as always.

Feature: between nodes on one machine, large messages go through shared memory, small ones and service calls over Unix
    sockets
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from typing import Any

import pytest
from harness import SOURCE, STOCK_PYTHON, Master, Process, until

from pyros1.msgs import load_message
from pyros1.node import Node

Image: Any = load_message("sensor_msgs/Image")
SIZE = 400_000

ROSPY = """
import sys, rospy
from sensor_msgs.msg import Image
rospy.init_node("relay_of_rospy")
publisher = rospy.Publisher(sys.argv[2], Image, queue_size=10)
rospy.Subscriber(sys.argv[1], Image, publisher.publish)
rospy.spin()
"""
OURS = """
import sys
from pyros1 import Node
from pyros1.msgs.sensor_msgs.msg import Image
with Node("relay_of_ours", argv=[]) as node:
    publisher = node.advertise(sys.argv[2], Image, queue_size=10)
    node.subscribe(sys.argv[1], Image, publisher.publish, arrays="memoryview")
    there = node.service(sys.argv[1] + "/there", "std_srvs/SetBool")
    node.advertise_service(sys.argv[2] + "/here", "std_srvs/SetBool", lambda request: there(request.data))
    node.spin()
"""
RELAYS = {
    "roscpp": ["/usr/lib/topic_tools/relay"],
    "rospy": [STOCK_PYTHON, "-c", ROSPY],
    "ours": [sys.executable, "-c", OURS],
}


class Heard:
    """A callback that keeps images."""

    def __init__(self) -> None:
        self.items: list[Any] = []
        self._changed = threading.Condition()

    def __call__(self, message: Any) -> None:
        with self._changed:
            self.items.append(message)
            self._changed.notify_all()

    def wait(self, count: int) -> list[Any]:
        with self._changed:
            assert self._changed.wait_for(lambda: len(self.items) >= count, 20), f"{len(self.items)} of {count}"
        return self.items


@pytest.fixture
def node(launcher: Master, topic: str) -> Iterator[Node]:
    """A node of ours in this process that shares memory with whoever can."""
    with Node(
        "local_" + topic.rpartition("/")[2], environ=launcher.environ("ours"), argv=[], handle_signals=False
    ) as node:
        yield node


def relay(launcher: Master, kind: str, source: str, target: str) -> Process:
    variables = {"PYTHONPATH": str(SOURCE)} if kind == "ours" else {}
    return launcher.run([*RELAYS[kind], source, target], label=f"relay of {kind}", **variables)


@pytest.mark.parametrize("kind", RELAYS)
def test_there_and_back(launcher: Master, node: Node, topic: str, kind: str) -> None:
    """Each message goes to a program of that kind, and comes back from it."""
    heard = Heard()
    node.subscribe(topic + "/out", Image, heard, arrays="memoryview")
    publisher = node.advertise(topic, Image, queue_size=10)
    relay(launcher, kind, topic, topic + "/out")
    assert publisher.wait_for_subscribers(timeout=20)
    # roscpp's relay advertises with the first message, and rospy's forgets what comes right after its greeting to us.

    def is_heard() -> bool:
        publisher.publish(Image(height=1, data=bytes(SIZE)))
        return bool(heard.items)

    until(is_heard, "the relay is linked both ways")
    for number in range(2, 30):
        publisher.publish(Image(height=number, data=bytes([number]) * SIZE))
        wait_for_height(heard, number)
    assert bytes(heard.items[-1].data) == bytes([29]) * SIZE
    expected = "LOCAL" if kind == "ours" else "TCPROS"
    bus = launcher.node(node.name, "getBusInfo")[2]
    assert {entry[3] for entry in bus if entry[4].startswith(topic)} == {expected}
    shown = subprocess.run(
        [STOCK_PYTHON, "/usr/bin/rosnode", "info", node.name],
        env=launcher.environ("stock"),
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert f"topic: {topic}\n    * to: " in shown.stdout and f"transport: {expected}" in shown.stdout, shown.stdout


# The interpreter may be where only this user can read.
MAY_READ = ["--inh-caps=+dac_override,+dac_read_search", "--ambient-caps=+dac_override,+dac_read_search"]
# Also where / is no mount point, as after chroot; /proc of all others stays as it is.
HIDE_PROC = 'mount --make-rprivate /proc && mount -t tmpfs none /proc && exec "$@"'
OUT_OF_REACH = {
    "a program of another user": ["setpriv", "--reuid=65534", "--clear-groups", *MAY_READ, "env", "HOME=/nonexistent"],
    "a program that has no /proc": ["unshare", "--mount", "--propagation", "unchanged", "sh", "-c", HIDE_PROC, "sh"],
}


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can start programs of other users")
@pytest.mark.parametrize("who", OUT_OF_REACH)
def test_who_cannot_share_memory_is_linked_over_tcp(launcher: Master, node: Node, topic: str, who: str) -> None:
    heard = Heard()
    node.subscribe(topic + "/out", Image, heard, arrays="memoryview")
    publisher = node.advertise(topic, Image, queue_size=10)
    node.advertise_service(topic + "/there", "std_srvs/SetBool", lambda request: (request.data, "from there"))
    launcher.run(
        [*OUT_OF_REACH[who], *RELAYS["ours"], topic, topic + "/out"],
        label=who,
        PYTHONPATH=str(SOURCE),
        ROS_LOG_DIR="/nonexistent",  # it cannot write the log of this user, and goes on
    )
    assert publisher.wait_for_subscribers(timeout=20)

    def is_heard() -> bool:
        publisher.publish(Image(height=7, data=bytes([7]) * SIZE))
        return bool(heard.items)

    until(is_heard, "the relay is linked both ways")
    assert bytes(heard.items[0].data) == bytes([7]) * SIZE
    bus = launcher.node(node.name, "getBusInfo")[2]
    assert [entry[3] for entry in bus if entry[4].startswith(topic)] == ["TCPROS", "TCPROS"]
    answer = node.service(topic + "/out/here", "std_srvs/SetBool")(True)
    assert answer.success and answer.message == "from there"


def test_all_of_them_at_once(launcher: Master, node: Node, topic: str) -> None:
    """Each gets all messages, in order, however it is linked."""
    heard = {kind: Heard() for kind in RELAYS}
    for kind in RELAYS:
        node.subscribe(f"{topic}/{kind}", Image, heard[kind])
    publisher = node.advertise(topic, Image, queue_size=100)
    for kind in RELAYS:
        relay(launcher, kind, topic, f"{topic}/{kind}")
    assert publisher.wait_for_subscribers(3, timeout=20)
    number = 0
    while not all(each.items for each in heard.values()):
        number += 1
        publisher.publish(Image(height=number, data=bytes(SIZE)))
        heard["ours"].wait(min(1, len(heard["ours"].items)))
        node.sleep(0.05)
    begin = number
    for number in range(begin + 1, begin + 50):
        publisher.publish(Image(height=number, data=bytes([number % 256]) * (SIZE + number)))
        for each in heard.values():
            each.wait(len(each.items))
        node.sleep(0.02)
    for kind, each in heard.items():
        each.wait(1)
        wait_for_height(each, number)
        heights = [message.height for message in each.items if message.height > begin]
        assert heights == [*range(begin + 1, number + 1)], kind
        assert all(set(message.data) == {message.height % 256} for message in each.items if message.height > begin)


def wait_for_height(heard: Heard, height: int) -> None:
    with heard._changed:
        assert heard._changed.wait_for(lambda: heard.items and heard.items[-1].height >= height, 20)
