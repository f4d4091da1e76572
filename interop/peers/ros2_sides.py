"""Stock ROS 1 nodes with `pyros1 bridge ros2` and a ROS 2 program at its other side."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

from harness import Master, Process, free_port, until

PEER = Path(__file__).parent / "ros2_sdk_peer.py"
START = 60.0
SERVER = """
import rospy
from std_srvs.srv import SetBool
def switch(request):
    if not request.data:
        raise rospy.ServiceException("it is on for good")
    return True, "switched by ROS 1"
rospy.init_node("switch")
service = rospy.Service("/ros1_switch", SetBool, switch)
rospy.spin()
"""


class Sides:
    """A stock master, the bridge, and a ROS 2 program, which uses zenoh-ros2-sdk."""

    def __init__(self, master: Master) -> None:
        self.master = master
        self.port = free_port()
        self.bridge = self.start_bridge()
        self.bridge.wait_line("^bridge to ROS 2", START)
        self.ros2 = self.start_ros2()

    def start(self, python: str, label: str, *command: str) -> Process:
        process = Process(command, self.master.environ(python), label)
        self.master.processes.append(process)
        return process

    def start_bridge(self) -> Process:
        endpoint = f"tcp/127.0.0.1:{self.port}"
        return self.start("ours", "bridge", sys.executable, "-m", "pyros1", "bridge", "ros2", "--listen", endpoint)

    def start_ros2(self) -> Process:
        process = self.start_peer()
        process.wait_line("^ready", START)
        return process

    def start_peer(self) -> Process:
        return self.start("ours", "ROS 2", sys.executable, str(PEER), str(self.port))

    def talker(self) -> Process:
        return self.start("stock", "rostopic pub", "rostopic", "pub", "-r", "10", "/from_ros1", "std_msgs/String", "hi")

    def listener(self) -> Process:
        return self.start("stock", "rostopic echo", "rostopic", "echo", "/from_ros2")

    def tool(self, *words: str) -> str:
        """Return what stock's rosservice prints."""
        command = ["rosservice", *words]
        environ = self.master.environ("stock")
        return subprocess.run(command, env=environ, capture_output=True, text=True, timeout=START, check=True).stdout

    def wait_called(self, word: str, pattern: str) -> None:
        """Let ROS 2 call the ROS 1 service until it gets a certain response: it may not be there yet."""

        def is_called() -> bool:
            before = len(self.ros2.lines)
            self.ros2.write(f"call {word}")
            self.ros2.wait_line("^(response|no response)", START)
            return any(re.search(pattern, line) for line in self.ros2.lines[before:])

        until(is_called, f"the call responds {pattern}", timeout=START)


def await_new(process: Process, pattern: str) -> None:
    """Wait for a line that is printed from now on."""
    before = len(process.lines)
    until(
        lambda: any(re.search(pattern, line) for line in process.lines[before:]),
        f"{process.label} prints {pattern}",
        timeout=START,
    )
