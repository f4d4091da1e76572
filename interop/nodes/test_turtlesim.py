"""turtlesim_node driven by stock's tools, a program of rospy, and roscpp's relay; poses beside the published equations.

Debian has no turtlesim, so what stock's tools need of it is made here by its own generators from the definitions.
"""

from __future__ import annotations

import cmath
import json
import shutil
import subprocess
import sys
from math import pi
from pathlib import Path

import pytest
from harness import STOCK_PYTHON, Master, until

import pyros1
from pyros1.turtlesim.turtle import STEP_PERIOD, WORLD_SIZE

MASTERS = ("stock",)  # all is stock's but the node
OWN_MASTER = True

SHIPPED = Path(pyros1.__file__).parent
SCRIPTS = SHIPPED / "packages" / "turtlesim" / "scripts"
GENERATORS = Path("/usr/lib/genpy")
RELAY = "/usr/lib/topic_tools/relay"

# Drives turtle1 for a while, and prints its poses as JSON until it stands still again.
DRIVER = """
import json, sys, threading, rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose
from turtlesim.srv import SetPen, Spawn, TeleportAbsolute

rospy.init_node("driver")
for service in ("spawn", "turtle1/teleport_absolute", "turtle1/set_pen"):
    rospy.wait_for_service(service, 30)
rospy.ServiceProxy("turtle1/set_pen", SetPen)(255, 0, 0, 5, 0)
rospy.ServiceProxy("turtle1/teleport_absolute", TeleportAbsolute)(2.0, 2.0, 0.5)
poses, ended = [], threading.Event()

def heard(pose):
    if len(poses) > 1 and not pose.linear_velocity and poses[-1][3]:
        ended.set()
    if not ended.is_set():
        poses.append([getattr(pose, name) for name in Pose.__slots__])

rospy.Subscriber("turtle1/pose", Pose, heard, queue_size=1000)
publisher = rospy.Publisher("commands", Twist, queue_size=1)
while not (publisher.get_num_connections() and poses) and not rospy.is_shutdown():
    rospy.sleep(0.05)
twist = Twist()
twist.linear.x, twist.linear.y, twist.angular.z = 2.0, 0.5, 0.75
until = rospy.get_time() + 20
while not any(pose[3] for pose in poses) and rospy.get_time() < until:
    publisher.publish(twist)  # again: a relay has subscribers only after its first message
    rospy.sleep(0.2)
assert ended.wait(30), poses[-3:]
try:
    rospy.ServiceProxy("spawn", Spawn)(1, 1, 0, "turtle1")
except rospy.ServiceException as error:
    refusal = str(error)
print("poses " + json.dumps([poses, refusal]))
"""


@pytest.fixture(scope="session")
def packages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the package turtlesim, and below python/ what stock's generators make of it."""
    home = tmp_path_factory.mktemp("packages")
    shutil.copytree(SHIPPED / "msgs" / "definitions" / "turtlesim", home / "turtlesim")
    shutil.copy(SHIPPED / "packages" / "turtlesim" / "package.xml", home / "turtlesim")
    for kind, program in (("msg", "genmsg_py.py"), ("srv", "gensrv_py.py")):
        out = home / "python" / "turtlesim" / kind
        out.mkdir(parents=True)
        files = sorted(map(str, (home / "turtlesim" / kind).iterdir()))
        words = [STOCK_PYTHON, str(GENERATORS / program), "-p", "turtlesim", "-o", str(out)]
        for more in (["-I", f"turtlesim:{home / 'turtlesim' / 'msg'}", *files], ["--initpy"]):
            subprocess.run([*words, *more], check=True, timeout=120, capture_output=True)
    (home / "python" / "turtlesim" / "__init__.py").touch()
    return home


def tool(launcher: Master, packages: Path, *words: str) -> str:
    """Run a tool of stock's, which finds turtlesim; return what it prints."""
    extra = {"PYTHONPATH": str(packages / "python"), "ROS_PACKAGE_PATH": f"{packages}:/usr/share"}
    process = launcher.run(list(words), **extra)
    process.wait(60)
    return "\n".join(process.lines)


@pytest.mark.ours_only
def test_stocks_tools_drive_the_turtle(launcher: Master, packages: Path) -> None:
    """Feature: turtlesim: stock's tools, a rospy program and roscpp's relay drive the turtles; poses follow
    the published equations -- `pyros1 run turtlesim turtlesim_node`
    """
    node = launcher.run([sys.executable, str(SCRIPTS / "turtlesim_node")], python="ours")
    node.wait_line(r"Spawning turtle \[turtle1\] at x=\[5\.544445\], y=\[5\.544445\], theta=\[0\.000000\]")
    until(lambda: launcher.publishers("/turtle1/pose"), "the turtle is there")
    sums = tool(launcher, packages, "rosmsg", "md5", "turtlesim/Pose")
    assert "863b248d5016ca62ea2e895ae5265cf9" in sums
    said = tool(launcher, packages, "rostopic", "echo", "-n", "1", "/turtle1/pose")
    assert "x: 5.544444561004639\ny: 5.544444561004639\ntheta: 0.0" in said
    assert "r: 69\ng: 86\nb: 255" in tool(launcher, packages, "rostopic", "echo", "-n", "1", "/turtle1/color_sensor")
    assert "turtle2" in tool(launcher, packages, "rosservice", "call", "/spawn", "3", "4", "0.5", "")
    said = tool(launcher, packages, "rosservice", "call", "/kill", "nobody")
    assert "ERROR" in said and "which does not exist" in said
    node.wait_line(r"\[ERROR\].*Tried to kill turtle \[nobody\], which does not exist")

    launcher.run([RELAY, "commands", "turtle1/cmd_vel"])  # roscpp between rospy and ours
    driver = launcher.run([STOCK_PYTHON, "-c", DRIVER], PYTHONPATH=str(packages / "python"))
    found = driver.wait_line(r"^poses (.*)$", 60)
    poses, refusal = json.loads(found[1])
    assert "A turtle named [turtle1] already exists" in refusal
    moving = [pose for pose in poses if pose[3]]
    assert len(moving) > 1, "a command holds for a second, 62 steps; many are left out on a busy machine"
    assert all(pose[3:] == pytest.approx([abs(2 + 0.5j), 0.75], abs=1e-6) for pose in moving)
    begin = poses[-len(moving) - 1]
    place, theta = complex(*begin[:2]), begin[2]
    assert begin[:3] == pytest.approx([2.0, 2.0, 0.5])
    reached = {0: place}
    for step in range(1, 600):
        theta += 0.75 * STEP_PERIOD
        place += (2 + 0.5j) * STEP_PERIOD * cmath.exp(1j * theta)
        place = complex(min(max(place.real, 0), WORLD_SIZE), min(max(place.imag, 0), WORLD_SIZE))
        reached[step] = place
    for x, y, angle, *_ in moving:
        turned = (angle - 0.5) % (2 * pi)
        step = round(turned / (0.75 * STEP_PERIOD))
        assert turned == pytest.approx(step * 0.75 * STEP_PERIOD, abs=1e-5)
        assert abs(complex(x, y) - reached[step]) < 1e-5
