"""Message modules that stock's genpy has generated, on our modules; pickles of stock; the graph of a running system."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from faces import FACES, START, run, same, start
from harness import SOURCE, Master

MASTERS = ("ours",)
STOCK = Path("/usr/lib/python3/dist-packages")

TALKER = """
import sys, rospy
import geometry_msgs.msg
from geometry_msgs.msg import PoseStamped, TwistStamped
from std_msgs.msg import Header
from std_srvs.srv import SetBool, SetBoolResponse
print(geometry_msgs.msg.__file__)
rospy.init_node("talker")
service = rospy.Service(sys.argv[1] + "_service", SetBool, lambda request: SetBoolResponse(request.data, "heard"))
publisher = rospy.Publisher(sys.argv[1], TwistStamped, queue_size=1, latch=True)
message = TwistStamped(header=Header(frame_id="map", stamp=rospy.Time(5)))
message.twist.linear.x = 1.5
publisher.publish(message)
print("ready", flush=True)
def hear(pose):
    print("pose", type(pose).__module__, pose.pose.position.x, pose.header.frame_id, flush=True)
rospy.Subscriber(sys.argv[1] + "_back", PoseStamped, hear)
rospy.spin()
"""
LISTENER = """
import sys, rospy
from geometry_msgs.msg import PoseStamped, TwistStamped
from std_srvs.srv import SetBool
rospy.init_node("listener")
message = rospy.wait_for_message(sys.argv[1], TwistStamped, timeout=20)
print(message.header.frame_id, message.header.stamp.secs, message.twist.linear.x, message._connection_header["type"])
rospy.wait_for_service(sys.argv[1] + "_service", 20)
print(rospy.ServiceProxy(sys.argv[1] + "_service", SetBool)(True).message)
back = rospy.Publisher(sys.argv[1] + "_back", PoseStamped, queue_size=1, latch=True)
pose = PoseStamped()
pose.header.frame_id, pose.pose.position.x = "odom", 2.5
back.publish(pose)
rospy.spin()  # stock drops what is still in its queue at the end
"""


@pytest.fixture
def devel(tmp_path: Path) -> Path:
    """The Python folder of a catkin devel space with generated messages."""
    for name in ("std_msgs", "geometry_msgs", "std_srvs"):
        shutil.copytree(STOCK / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


@pytest.mark.parametrize("other", ["stock", "ours"])
def test_a_node_with_generated_messages(launcher: Master, topic: str, devel: Path, other: str) -> None:
    talker = start("ours", launcher, TALKER, topic, PYTHONPATH=f"{START}:{SOURCE}:{devel}")
    assert talker.wait_line("__init__").string.startswith(str(devel))
    talker.wait_line("ready")
    listener = start(other, launcher, LISTENER, topic)
    listener.wait_line("^map 5 1.5 geometry_msgs/TwistStamped$")
    listener.wait_line("^heard$")
    assert talker.wait_line("^pose").string == "pose geometry_msgs.msg._PoseStamped 2.5 odom"


PICKLE = """
import pickle, sys
from geometry_msgs.msg import TwistStamped
from std_msgs.msg import String
import genpy
with open(sys.argv[1], sys.argv[2]) as file:
    if sys.argv[2] == "wb":
        message = TwistStamped()
        message.header.frame_id, message.header.stamp = "map", genpy.Time(3, 4)
        pickle.dump([message, String("a"), genpy.Duration(-1, 5)], file)
    else:
        print(*pickle.load(file))
"""


@pytest.mark.parametrize("writer", FACES)
def test_pickles_can_be_read_by_both(master: Master, tmp_path: Path, writer: str) -> None:
    run(writer, master, PICKLE, str(tmp_path / "p"), "wb")
    assert 'frame_id: "map"' in same(master, PICKLE, str(tmp_path / "p"), "rb")


GRAPH = """
import sys, time
import rosgraph.impl.graph as views
topic = sys.argv[1]
graph = views.Graph(topic_ns=topic)
graph.set_master_stale(0.05)
graph.set_node_stale(0.05)
end = time.monotonic() + 20
while time.monotonic() < end and len(list(graph.nt_edges)) < 2:
    graph.update()
    time.sleep(0.1)
for edges in (graph.nn_edges, graph.nt_edges, graph.nt_all_edges):
    print(sorted((edge.start, edge.end, edge.label) for edge in edges))
print(sorted(graph.nt_nodes), {"/talker1", "/listener1"} <= graph.nn_nodes, graph.bad_nodes)
"""
END = """
import sys, rospy
from std_msgs.msg import String
rospy.init_node(sys.argv[2])
if sys.argv[2] == "talker1":
    publisher = rospy.Publisher(sys.argv[1], String, queue_size=1)
else:
    subscriber = rospy.Subscriber(sys.argv[1], String, print)
print("ready", flush=True)
rospy.spin()
"""


def test_the_graph(launcher: Master, topic: str) -> None:
    for face, name in (("ours", "talker1"), ("stock", "listener1")):
        start(face, launcher, END, topic, name).wait_line("ready")
    said = same(launcher, GRAPH, topic)
    assert f"('/talker1', '/listener1', '{topic}')" in said


NAMES = """
import sys
from importlib import import_module
for package in sys.argv[1:]:
    for kind in ("msg", "srv"):
        try:
            module = import_module(f"{package}.{kind}")
        except ModuleNotFoundError:
            continue
        print(module.__name__)
        brought, types = {}, sorted(name for name in dir(module) if name[0] == "_" and name[1] != "_")
        exec(f"from {package}.{kind} import *", brought)
        print(sorted(brought), [name for name in dir(module) if name[:2] != "__"])
        print(sorted(name for name in module.__dict__ if name[:2] != "__"))
        for name in sorted(name for name in brought if name[:2] != "__"):
            value = brought[name]
            print(name, getattr(value, "__name__", value), getattr(module, name) is value, isinstance(value, type))
        for name in types:
            only = {}
            exec(f"from {package}.{kind}.{name} import *", only)
            print(name, sorted(only), getattr(module, name).__name__, import_module(f"{package}.{kind}.{name}").__name__)
            print([getattr(module, name).__dict__[each] is value for each, value in sorted(only.items()) if each[0] != "_"])
"""


def test_stocks_packages_have_the_same_names(master: Master) -> None:
    """Of `from PACKAGE.msg import *` and the modules of single types, in all packages of messages that Debian has."""
    packages = sorted(
        {path.parent.parent.name for kind in ("msg", "srv") for path in STOCK.glob(f"*/{kind}/__init__.py")}
    )
    assert len(packages) > 15
    same(master, NAMES, *packages)
