"""By hand: how long a message takes from ROS 2 to ROS 1 and back through `pyros1 bridge ros2 --via rclpy`, and how many
messages pass, beside a hop between two nodes of rclpy; see interop/ros2.md.

It needs stock's rospy in /usr/bin/python3, and a Python with rclpy and pyros1, see test_rclpy.py::

    ros2/bin/python interop/ros2/latency.py

Each row is a talker and a listener, in processes of their own. Messages carry the monotonic time at which they were
made, so all of ROS's encoding counts.
"""

from __future__ import annotations

import contextlib
import json
import os
import random
import signal
import subprocess
import sys
import time
from array import array
from collections.abc import Callable, Iterator
from typing import Any

STOCK_PYTHON = "/usr/bin/python3"
IMAGE_SIZE = (1500, 1333)
WAYS = (("rclpy", "rclpy"), ("rclpy", "rospy"), ("rospy", "rclpy"), ("rospy", "rospy"))
# Name -> type, messages per second (0: as many as possible), seconds.
LOADS = {
    "String, 100 Hz": ("String", 100, 5),
    "String, flood": ("String", 0, 3),
    "Image, 6 MB, 30 Hz": ("Image", 30, 5),
}
QUIET = 3.0
START = 60.0


def make(module: Any, is_ros1: bool) -> Any:
    """Return a message with the time."""
    now = str(time.monotonic_ns())
    if module.__name__.endswith("String"):
        return module(data=now)
    message = module(height=IMAGE_SIZE[1], width=IMAGE_SIZE[0], step=3 * IMAGE_SIZE[0], encoding="rgb8")
    message.header.frame_id = now
    message.data = PIXELS if is_ros1 else array("B", PIXELS)
    return message


PIXELS = bytes(3 * IMAGE_SIZE[0] * IMAGE_SIZE[1])


class Listener:
    """Notes when messages come."""

    def __init__(self) -> None:
        self.latencies: list[float] = []
        self.first = self.last = 0.0

    def take(self, message: Any) -> None:
        """Note a message."""
        now = time.monotonic_ns()
        made = int(
            message.data if hasattr(message, "data") and isinstance(message.data, str) else message.header.frame_id
        )
        self.latencies.append((now - made) / 1e6)
        self.last = now / 1e9
        self.first = self.first or self.last

    def report(self) -> None:
        """Wait until no more comes, and print it."""
        print("ready", flush=True)
        end = time.monotonic() + START
        while time.monotonic() < end and not (self.last and time.monotonic() - self.last > QUIET):
            time.sleep(0.1)
        print(json.dumps([self.latencies, self.last - self.first]), flush=True)


def talk(publish: Callable[[], object], rate: int, seconds: float) -> None:
    """Publish for some time, and print how many messages that were."""
    end, sent, due = time.monotonic() + seconds, 0, time.monotonic()
    while time.monotonic() < end:
        publish()
        sent += 1
        if rate:
            due += 1 / rate
            time.sleep(max(0.0, due - time.monotonic()))
    print(sent, flush=True)
    time.sleep(QUIET + 2)  # so that what waits can be sent


def run_rospy(role: str, type_name: str, rate: int, seconds: float) -> None:
    """Be a ROS 1 node."""
    import rospy  # only in stock's Python
    import sensor_msgs.msg
    import std_msgs.msg

    module = {"String": std_msgs.msg.String, "Image": sensor_msgs.msg.Image}[type_name]
    rospy.init_node(f"latency_{role}", anonymous=True)
    if role == "listen":
        listener = Listener()
        rospy.Subscriber("/latency", module, listener.take, tcp_nodelay=True, buff_size=1 << 24)
        listener.report()
        return
    publisher = rospy.Publisher("/latency", module, queue_size=10, tcp_nodelay=True)
    while not publisher.get_num_connections():
        time.sleep(0.05)
    time.sleep(2)
    talk(lambda: publisher.publish(make(module, True)), rate, seconds)


def run_rclpy(role: str, type_name: str, rate: int, seconds: float) -> None:
    """Be a ROS 2 node."""
    import threading
    from importlib import import_module

    rclpy: Any = import_module("rclpy")
    package = {"String": "std_msgs", "Image": "sensor_msgs"}[type_name]
    module = getattr(import_module(f"{package}.msg"), type_name)
    rclpy.init()
    node = rclpy.create_node(f"latency_{role}")
    if role == "listen":
        listener = Listener()
        node.create_subscription(module, "/latency", listener.take, 10)
        threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()
        listener.report()
        os._exit(0)
    publisher = node.create_publisher(module, "/latency", 10)
    while not publisher.get_subscription_count():
        time.sleep(0.05)
    time.sleep(2)
    talk(lambda: publisher.publish(make(module, False)), rate, seconds)


@contextlib.contextmanager
def running(*command: str) -> Iterator[subprocess.Popen[str]]:
    """Run a program, and end it."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True) as process:
        try:
            yield process
        finally:
            process.send_signal(signal.SIGINT)
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()


def processor_seconds(pid: int) -> float:
    """Return how long a process has run."""
    with open(f"/proc/{pid}/stat", encoding="ascii") as file:
        fields = file.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def measure(talker: str, listener: str, load: str, bridge: int) -> str:
    """Return a row of the table."""
    type_name, rate, seconds = LOADS[load]
    pythons = {"rclpy": sys.executable, "rospy": STOCK_PYTHON}
    words = [type_name, str(rate), str(seconds)]
    with running(pythons[listener], __file__, listener, "listen", *words) as listening:
        assert listening.stdout is not None
        listening.stdout.readline()
        with running(pythons[talker], __file__, talker, "talk", *words) as talking:
            assert talking.stdout is not None
            before = processor_seconds(bridge)
            sent = int(talking.stdout.readline() or 0)
            latencies, took = json.loads(listening.stdout.readline())
            used = processor_seconds(bridge) - before
    latencies.sort()
    if not latencies:
        return f"| {talker} -> {listener} | {load} | 0 of {sent} | - | - | - | - |"
    share = "-" if talker == listener else f"{used / max(seconds, took):.0%}"
    cells = [
        f"{talker} -> {listener}" if talker == listener else f"{talker} -> bridge -> {listener}",
        load,
        f"{len(latencies)} of {sent}",
        f"{len(latencies) / took:.0f}",
        f"{latencies[len(latencies) // 2]:.1f}",
        f"{latencies[int(0.99 * len(latencies))]:.1f}",
        share,
    ]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Print the table."""
    port, domain = random.randrange(20000, 32000), random.randrange(1, 100)
    os.environ.update(
        ROS_MASTER_URI=f"http://localhost:{port}",
        ROS_HOSTNAME="localhost",
        ROS_DOMAIN_ID=str(domain),
        ROS_AUTOMATIC_DISCOVERY_RANGE="LOCALHOST",
    )
    with running(sys.executable, "-m", "pyros1", "core", "-p", str(port)):
        time.sleep(3)
        with running(sys.executable, "-m", "pyros1", "bridge", "ros2", "--via", "rclpy") as bridge:
            time.sleep(3)
            print("| way | messages | arrived | per second | ms, half | ms, 99 % | processor of the bridge |")
            print("|---|---|---|---|---|---|---|", flush=True)
            for load in sys.argv[1:] or LOADS:
                for talker, listener in WAYS:
                    print(measure(talker, listener, load, bridge.pid), flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] in (["rospy"], ["rclpy"]):
        kind, given_role, given_type, given_rate, given_seconds = sys.argv[1:]
        with contextlib.suppress(KeyboardInterrupt):
            {"rospy": run_rospy, "rclpy": run_rclpy}[kind](
                given_role, given_type, int(given_rate), float(given_seconds)
            )
    else:
        main()
