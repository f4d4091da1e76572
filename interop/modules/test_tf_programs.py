"""Programs with tf on both faces: the tutorial's turtles, clients of a buffer server, and stock's own tools."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from shlex import split

import pytest
from faces import FACES, command, environ, run, start
from harness import Master, Process, until

pytestmark = pytest.mark.ours_only
tools = pytest.mark.skipif(
    not Path("/usr/lib/tf2_tools/echo.py").exists(), reason="tf2-tools is not installed; run interop/setup"
)

# The tutorial's turtles: one walks in a circle, the other follows it by way of tf.
WALKER = """
import math
import rospy, tf, tf2_ros
from geometry_msgs.msg import TransformStamped
from tf.transformations import quaternion_from_euler

rospy.init_node("walker")
sender, old, static = tf2_ros.TransformBroadcaster(), tf.TransformBroadcaster(), tf2_ros.StaticTransformBroadcaster()
carrot = TransformStamped()
carrot.header.stamp = rospy.Time.now()
carrot.header.frame_id, carrot.child_frame_id = "turtle1", "carrot1"
carrot.transform.translation.y, carrot.transform.rotation.w = 2.0, 1.0
static.sendTransform(carrot)
rate, step = rospy.Rate(100), 0
while not rospy.is_shutdown():
    angle = 0.01 * step
    it = TransformStamped()
    it.header.stamp, it.header.frame_id, it.child_frame_id = rospy.Time.now(), "world", "turtle1"
    it.transform.translation.x, it.transform.translation.y = 3 * math.cos(angle), 3 * math.sin(angle)
    rotation = it.transform.rotation
    rotation.x, rotation.y, rotation.z, rotation.w = quaternion_from_euler(0, 0, angle + math.pi / 2)
    sender.sendTransform(it)
    old.sendTransform((5.0, 1.0, 0.0), quaternion_from_euler(0, 0, 0), rospy.Time.now(), "turtle2", "world")
    step += 1
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        break
"""

FOLLOWER = """
import math
import rospy, tf, tf2_ros
import tf2_geometry_msgs
from geometry_msgs.msg import PointStamped

rospy.init_node("follower")
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)
old = tf.TransformListener()
there = buffer.lookup_transform("turtle2", "turtle1", rospy.Time(0), rospy.Duration(20))
spot = there.transform.translation
print("distance", 1.9 < math.hypot(spot.x, spot.y) < 8.1, there.header.frame_id, there.child_frame_id)
carrot = buffer.lookup_transform("turtle1", "carrot1", rospy.Time(0), rospy.Duration(20))
print("carrot", round(carrot.transform.translation.y, 6))
past = rospy.Time.now()
buffer.lookup_transform("turtle2", "turtle1", past, rospy.Duration(20))
buffer.lookup_transform_full("turtle2", rospy.Time.now(), "turtle1", past, "world", rospy.Duration(20))
point = PointStamped()
point.header.frame_id, point.point.x = "turtle1", 1.0
print("point", buffer.transform(point, "world", rospy.Duration(20)).header.frame_id)
old.waitForTransform("/turtle2", "/carrot1", rospy.Time(0), rospy.Duration(20))
place, turn = old.lookupTransform("/turtle2", "/carrot1", rospy.Time(0))
print("old", len(place), len(turn), sorted(old.getFrameStrings()), old.frameExists("carrot1"))
now = rospy.Time.now()
old.waitForTransform("turtle1", "world", now, rospy.Duration(20))
print("now", len(old.lookupTransform("turtle1", "world", now)))
for target, source in (("turtle1", "nowhere"), ("nowhere", "turtle1")):
    try:
        buffer.lookup_transform(target, source, rospy.Time(0), rospy.Duration(0.2))
    except tf2_ros.TransformException as error:
        print(type(error).__name__, error)
    try:
        old.waitForTransform(target, source, rospy.Time(0), rospy.Duration(0.2))
    except tf.Exception as error:
        print(type(error).__name__, error)
from tf2_msgs.srv import FrameGraph
rospy.wait_for_service("~tf2_frames", 20)
lines = rospy.ServiceProxy("~tf2_frames", FrameGraph)().frame_yaml.splitlines()
print(sorted(line for line in lines if line[0] != " "))
listener.unregister()
"""

ASKER = (Path(__file__).resolve().parents[1] / "peers" / "tf_asking.py").read_text()
TF, TF2_TOOLS = Path("/usr/lib/tf"), Path("/usr/lib/tf2_tools")
PUBLISHER = "/usr/lib/tf2_ros/static_transform_publisher"


@pytest.mark.parametrize("pair", [("ours", "stock"), ("stock", "ours"), ("ours", "ours")], ids="-".join)
def test_turtles(launcher: Master, pair: tuple[str, str]) -> None:
    """Feature: Python programs that use tf, tf2_ros, tf2_py, tf2_geometry_msgs, interactive_markers run
    unchanged -- results equal stock's
    """
    start(pair[0], launcher, WALKER)
    said = run(pair[1], launcher, FOLLOWER)
    assert said == run("stock", launcher, FOLLOWER)
    assert "distance True turtle2 turtle1" in said and "carrot 2.0" in said


@pytest.fixture
def frames(launcher: Master) -> None:
    """Transforms map -> base -> lidar of stock's publishers, and a frame elsewhere."""
    for words in ("1 2 3 0.1 0.2 0.3 map base", "0 0 1 0 0 0 base lidar", "0 0 1 0 0 0 island shore"):
        launcher.run([PUBLISHER, *split(words), f"__name:=to_{words.rpartition(' ')[2]}"], python="stock")
    nodes = {"/to_base", "/to_lidar", "/to_shore"}
    until(lambda: nodes <= set(launcher.publishers("/tf_static")), "the publishers of transforms")


def test_clients_of_a_buffer_server(launcher: Master, frames: None) -> None:
    """The same answers of stock's server in C++ for tf2_ros.BufferClient of both."""
    launcher.run(["/usr/lib/tf2_ros/buffer_server"], python="stock")
    stock, ours = (run(face, launcher, ASKER, "/tf2_buffer_server") for face in FACES)
    assert ours == stock
    assert "LookupException" in ours and "ExtrapolationException" not in ours.splitlines()[0]


def tool(face: str, launcher: Master, path: Path, *words: str, cwd: Path | None = None) -> Process:
    """Start one of stock's scripts on the modules of a face."""
    line = [*command(face, path), *words]
    if cwd is not None:
        line = ["env", "-C", str(cwd), *line]
    process = Process(line, environ(face, launcher, PYTHONUNBUFFERED="1"), label=path.name)
    launcher.processes.append(process)
    return process


@tools
def test_echo_of_tf2_tools(launcher: Master, frames: None) -> None:
    said = {}
    for face in FACES:
        echo = tool(face, launcher, TF2_TOOLS / "echo.py", "map", "lidar")
        echo.wait_line("^At time")
        said[face] = [
            echo.wait_line(word).string for word in ("Translation", "Quaternion", "RPY .radian", "RPY .degree")
        ]
    assert said["ours"] == said["stock"]


@tools
def test_view_frames_of_tf2_tools(launcher: Master, frames: None, tmp_path: Path) -> None:
    drawn = {}
    for face in FACES:
        folder = tmp_path / face
        folder.mkdir()
        tool(face, launcher, TF2_TOOLS / "view_frames.py", cwd=folder).wait(60)
        graph = (folder / "frames.gv").read_text()
        # which of several roots bears the legend is left to chance
        drawn[face] = sorted(re.sub(r"\d+\.\d+|(?<=}->).*;", "#", graph).splitlines())
    assert drawn["ours"] == drawn["stock"]
    assert any('"map" -> "base"' in line for line in drawn["ours"])


SIMULATED = """
import threading
import rospy, tf2_ros
from geometry_msgs.msg import TransformStamped
from rosgraph_msgs.msg import Clock

rospy.set_param("/use_sim_time", True)
rospy.init_node("simulated")
clock = rospy.Publisher("/clock", Clock, queue_size=1)
now, ended = [100.0], threading.Event()

def tick():
    while not ended.wait(0.005):
        now[0] += 0.05
        clock.publish(Clock(rospy.Time.from_sec(now[0])))

ticking = threading.Thread(target=tick)
ticking.start()
while rospy.get_time() < 100.0:
    rospy.rostime.wallsleep(0.01)
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)
start = rospy.Time.now()
print(buffer.can_transform("map", "base", rospy.Time(0), rospy.Duration(2.0), return_debug_tuple=True))
waited = (rospy.Time.now() - start).to_sec()
print(2.0 <= waited < 30.0)
sender, static = tf2_ros.TransformBroadcaster(), tf2_ros.StaticTransformBroadcaster()

def stamped(parent, child):
    it = TransformStamped()
    it.header.frame_id, it.child_frame_id, it.header.stamp = parent, child, rospy.Time.now()
    it.transform.rotation.w = 1.0
    return it

static.sendTransform(stamped("base", "fixed"))
while not buffer.can_transform("map", "fixed", rospy.Time(0)):
    sender.sendTransform(stamped("map", "base"))
    rospy.rostime.wallsleep(0.01)
print("there")
now[0] = 50.0  # as when a bag is played again
while buffer.can_transform("map", "base", rospy.Time(0)):
    sender.sendTransform(stamped("elsewhere", "other"))
    rospy.rostime.wallsleep(0.01)
print("cleared", buffer.can_transform("base", "fixed", rospy.Time(0)))
ended.set()
ticking.join()
"""


def test_simulated_time(own_master: Callable[[str], Master]) -> None:
    said = {}
    for face in FACES:
        master = own_master("ours")
        master.start()
        said[face] = run(face, master, SIMULATED)
    assert said["ours"] == said["stock"]
    assert "True\nthere\ncleared 1" in said["ours"]


OLD_SENDER = """
import rospy
from geometry_msgs.msg import TransformStamped
from tf.msg import tfMessage
rospy.init_node("old")
sender = rospy.Publisher("/tf_old", tfMessage, queue_size=1)
it = TransformStamped()
it.header.frame_id, it.child_frame_id, it.transform.rotation.w = "a", "c", 1.0
rate = rospy.Rate(50)
while not rospy.is_shutdown():
    it.header.stamp = rospy.Time.now()
    sender.publish(tfMessage([it]))
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        break
"""
NEW_LISTENER = """
import rospy, tf2_ros
rospy.init_node("new")
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)
print(buffer.can_transform("b", "c", rospy.Time(0), rospy.Duration(20)))
"""


@tools
def test_tf_remap_of_tf(launcher: Master) -> None:
    start("stock", launcher, OLD_SENDER)
    tool("ours", launcher, TF / "tf_remap", "_mappings:=[{old: a, new: b}]")
    assert run("ours", launcher, NEW_LISTENER) == "1\n"
