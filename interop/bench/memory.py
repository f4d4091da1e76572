"""How much memory a master, a node, and the server of the page need.

    python3 interop/bench/memory.py --side ours|roscpp|rospy [--web]

Needs pyros1 and defusedxml on PYTHONPATH; --web also what the page needs. Prints a JSON object of figures in MB. They
are the resident sets that `ps` shows, of all processes of a program, two seconds after it is ready: of a master with
rosout (stock's has three processes), and of a node that publishes and subscribes to a topic at 10 Hz (roscpp's is a
relay); with --web of `pyros1 web` after a client has requested its page.
"""

from __future__ import annotations

import argparse
import json
import os
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
import xmlrpc.client
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

STOCK_PYTHON = "/usr/bin/python3"
MASTER, NODE, WEB = "master with rosout", "node with a publisher and a subscriber", "web"
SETTLING = 2.0  # seconds from when a program is ready until its memory is measured
DEADLINE = 60.0

OURS = """
from pyros1 import Node
from pyros1.msgs.std_msgs.msg import Float64
with Node("bench") as node:
    publisher = node.advertise("/out", Float64, queue_size=10)
    node.subscribe("/out", Float64, lambda message: None)
    node.timer(0.1, lambda event: publisher.publish(Float64(1.0)))
    node.spin()
"""
ROSPY = """
import rospy
from std_msgs.msg import Float64
rospy.init_node("bench")
publisher = rospy.Publisher("/out", Float64, queue_size=10)
rospy.Subscriber("/out", Float64, lambda message: None)
timer = rospy.Timer(rospy.Duration(0.1), lambda event: publisher.publish(Float64(1.0)))
rospy.spin()
"""
NODES = {
    "ours": [STOCK_PYTHON, "-c", OURS],
    "rospy": [STOCK_PYTHON, "-c", ROSPY],
    "roscpp": ["/usr/lib/topic_tools/relay", "/in", "/out"],
}


def main() -> int:
    """Measure once and print the figures."""
    parser = argparse.ArgumentParser(description="Memory of a master, a node, and the server of the page.")
    parser.add_argument("--side", choices=NODES, required=True)
    parser.add_argument("--web", action="store_true", help="only the server of the page")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as home:
        port = free_port()
        os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_HOSTNAME="127.0.0.1", ROS_HOME=home)
        pyros1 = [sys.executable, "-m", "pyros1"]
        core = [*pyros1, "core"] if options.side == "ours" else ["roscore"]
        with running([*core, "-p", str(port)], lambda: is_registered("/rosout")) as master:
            if options.web:
                page = f"http://127.0.0.1:{(page_port := free_port())}/"
                with running([*pyros1, "web", "--port", str(page_port)], lambda: answers(page)) as web:
                    figures = {WEB: memory(web)}
            else:
                with running(NODES[options.side], is_node_registered) as node:
                    figures = {MASTER: memory(master), NODE: memory(node)}
    print(json.dumps(figures))
    return 0


@contextmanager
def running(command: list[str], is_ready: Callable[[], bool]) -> Iterator[int]:
    """Run a program until its memory has been measured, and yield its process id once it is ready."""
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as child:
        try:
            deadline = time.monotonic() + DEADLINE
            while not is_ready():
                if child.poll() is not None or time.monotonic() > deadline:
                    child.kill()
                    raise SystemExit(f"{command}: not ready\n{child.communicate()[1].decode()}")
                time.sleep(0.05)
            time.sleep(SETTLING)
            yield child.pid
        finally:
            child.terminate()
            child.communicate(timeout=DEADLINE)


def is_registered(name: str) -> bool:
    """Return whether a master is there that knows a node."""
    with xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"]) as master:
        try:
            return bool(master.lookupNode("/bench", name)[0] == 1)  # type: ignore[index]
        except OSError:
            return False


def is_node_registered() -> bool:
    """Return whether another node than rosout publishes."""
    with xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"]) as master:
        publishers = master.getSystemState("/bench")[2][0]  # type: ignore[index]
        return any(set(names) - {"/rosout"} for topic, names in publishers if topic == "/rosout")  # type: ignore[union-attr]


def answers(url: str) -> bool:
    """Return whether a page can be had, with an error perhaps."""
    try:
        urllib.request.urlopen(url, timeout=5.0).close()
    except urllib.error.HTTPError:
        return True
    except OSError:
        return False
    return True


def memory(pid: int) -> float:
    """Return the resident set of a process and all its descendants in MB."""
    status = Path(f"/proc/{pid}/status").read_text()
    own = int(status.partition("VmRSS:")[2].split()[0]) * 1024 / 1e6
    children = [
        child for task in Path(f"/proc/{pid}/task").iterdir() for child in (task / "children").read_text().split()
    ]
    return own + sum(memory(int(child)) for child in children)


def free_port() -> int:
    """Return a port that was free a moment ago."""
    with socket.create_server(("127.0.0.1", 0)) as sock:
        return int(sock.getsockname()[1])


if __name__ == "__main__":
    sys.exit(main())
