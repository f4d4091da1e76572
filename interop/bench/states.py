"""What robot_state_publisher costs with 100 joints at 100 Hz: ours beside stock's (C++).

::

    python interop/bench/states.py [--joints 100] [--hz 100] [--seconds 10]

A process publishes joint states and hears /tf: it prints the time between both, and the processor time of the node.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import threading
import time
from pathlib import Path
from statistics import median
from typing import Any

from pyros1.master.server import Master
from pyros1.msgs.sensor_msgs.msg import JointState
from pyros1.msgs.tf2_msgs.msg import TFMessage
from pyros1.node import Node

TICKS = os.sysconf("SC_CLK_TCK")
PROGRAMS = {
    "ours": [sys.executable, "-m", "pyros1.urdf.state_publisher"],
    "stock": ["/usr/lib/robot_state_publisher/robot_state_publisher"],
}


def robot(count: int) -> str:
    """Return a robot with joints that all move."""
    links = "".join(f'<link name="link_{number}"/>' for number in range(count + 1))
    joints = "".join(
        f'<joint name="joint_{number}" type="continuous"><parent link="link_{number // 4}"/>'
        f'<child link="link_{number + 1}"/><origin xyz="0.1 0 0.2" rpy="0.1 0.2 0.3"/><axis xyz="0 1 1"/></joint>'
        for number in range(count)
    )
    return f'<robot name="bench">{links}{joints}</robot>'


def seconds_of(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def measure(who: str, count: int, hz: float, seconds: float) -> str:
    """Return a row of the table."""
    server = Master(port=0, bind_host="127.0.0.1")
    server.start()
    environ = {**os.environ, "ROS_MASTER_URI": server.uri, "ROS_HOSTNAME": "localhost"}
    node = Node("bench", argv=[], environ=environ, handle_signals=False)
    node.params["/robot_description"] = robot(count)
    node.params["/tool/ignore_timestamp"] = True  # late messages come in pairs
    came: dict[int, float] = {}
    ready = threading.Event()

    def heard(message: Any) -> None:
        came[message.transforms[0].header.stamp.to_nsec()] = time.monotonic()
        ready.set()

    node.subscribe("/tf", TFMessage, heard, tcp_nodelay=True)
    process = subprocess.Popen([*PROGRAMS[who], "__name:=tool"], env=environ)
    try:
        publisher = node.advertise("/joint_states", JointState)
        assert publisher.wait_for_subscribers(timeout=20)
        names = [f"joint_{number}" for number in range(count)]
        while not ready.wait(0.1):  # both links are there
            message = JointState(name=names, position=[0.0] * count)
            message.header.stamp = node.now()
            publisher.publish(message)
        sent: dict[int, float] = {}
        began, due = seconds_of(process.pid), time.monotonic()
        for step in range(int(seconds * hz)):
            message = JointState(name=names, position=[0.01 * step] * count)
            message.header.stamp = node.now()
            sent[message.header.stamp.to_nsec()] = time.monotonic()
            publisher.publish(message)
            due += 1 / hz
            time.sleep(max(0.0, due - time.monotonic()))
        time.sleep(0.5)
        used = (seconds_of(process.pid) - began) / seconds
        late = sorted((came[at] - when) * 1e3 for at, when in sent.items() if at in came)
        lost = len(sent) - len(late)
        return f"| {who} | {used:.1%} | {median(late):.2f} | {late[int(len(late) * 0.99)]:.2f} | {lost} |"
    finally:
        process.terminate()
        process.wait(10)
        node.shutdown()
        server.stop()


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--joints", type=int, default=100)
    parser.add_argument("--hz", type=float, default=100.0)
    parser.add_argument("--seconds", type=float, default=10.0)
    options = parser.parse_args()
    print("| node | processor | delay, median (ms) | delay, 99 % (ms) | lost |\n|---|---|---|---|---|")
    for who in PROGRAMS:
        print(measure(who, options.joints, options.hz, options.seconds), flush=True)


if __name__ == "__main__":
    main()
