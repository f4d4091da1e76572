"""The classic tutorials of rospy as pairs of programs, each half on stock's modules or on ours, all with one output."""

from __future__ import annotations

import itertools
import re

import pytest
from faces import FACES, run, start
from harness import Master

MASTERS = ("ours",)
pytestmark = pytest.mark.ours_only

# What both halves begin with: a name that tells which half it is, and the end of a half when the other one has gone.
BEGIN = """
import sys, threading
import numpy, rospy
rospy.init_node(HALF, anonymous=False)

def while_heard(publisher):
    '''Wait until a subscriber has come and gone.'''
    while publisher.get_num_connections() and not rospy.is_shutdown():
        rospy.sleep(0.01)

def connected(*publishers):
    for publisher in publishers:
        while publisher.get_num_connections() < 1 and not rospy.is_shutdown():
            rospy.sleep(0.01)
"""


def same_in_all_pairs(master: Master, first: str, second: str, *arguments: str) -> str:
    """Run two programs in four pairs, require that each prints the same in all of them, and return what they print."""
    said = {}
    for pair in itertools.product(FACES, FACES):
        texts = (f"HALF = {half!r}\n{BEGIN}{text}" for half, text in (("first", first), ("second", second)))
        one = start(pair[0], master, next(texts), *arguments)
        other = run(pair[1], master, next(texts), *arguments)
        one.wait_line("^finished$")
        assert one.wait() == 0, one.transcript()
        lines = [
            line for line in one.lines if not re.match(r"\[[A-Z]+\]|\['Traceback|Traceback|  |ValueError|$", line)
        ]  # no log
        said[pair] = "\n".join(lines) + "\n" + other
    reference = said["stock", "stock"]
    for pair, text in said.items():
        assert text == reference, pair
    return reference


def test_talker_and_listener(launcher: Master) -> None:
    talker = """
from std_msgs.msg import String
pub = rospy.Publisher("chatter", String, queue_size=1000)
connected(pub)
rate = rospy.Rate(200)
count = 0
while pub.get_num_connections() and not rospy.is_shutdown():
    pub.publish("hello world %s" % count)
    count += 1
    rate.sleep()
print("finished")
"""
    listener = """
from std_msgs.msg import String
heard = []
def callback(data):
    heard.append(data.data)
    if len(heard) == 20:
        rospy.signal_shutdown("enough")
sub = rospy.Subscriber("chatter", String, callback)
rospy.on_shutdown(lambda: print("bye", rospy.get_caller_id()))
rospy.spin()
numbers = [int(each.split()[-1]) for each in heard[:20]]
print(heard[0].startswith("hello world"), numbers == list(range(numbers[0], numbers[0] + 20)), sub.name, sub.type)
"""
    out = same_in_all_pairs(launcher, talker, listener)
    assert "bye /second\nTrue True /chatter std_msgs/String" in out


def test_services(launcher: Master) -> None:
    server = """
from nav_msgs.srv import GetPlan, GetPlanResponse
from std_srvs.srv import Empty, SetBool, SetBoolResponse, Trigger
def add(req):
    response = GetPlanResponse()
    response.plan.header.frame_id = req.start.header.frame_id + req.goal.header.frame_id
    response.plan.poses = [req.start, req.goal]
    response.plan.poses[0].pose.position.x += req.goal.pose.position.x
    return response
ending = threading.Event()
def judge(req):
    if not req.data:
        raise ValueError("refused")
    return True, "positional"
services = [rospy.Service("add_two_poses", GetPlan, add), rospy.Service("judge", SetBool, judge),
            rospy.Service("dict", Trigger, lambda req: {"success": True, "message": "dict"}),
            rospy.Service("nothing", SetBool, lambda req: None)]
rospy.Service("end", Empty, lambda req: ending.set() or [])
while not ending.wait(0.05):
    pass
print("finished")
"""
    client = """
from nav_msgs.srv import GetPlan, GetPlanRequest
from std_srvs.srv import Empty, SetBool, SetBoolRequest, Trigger
rospy.wait_for_service("end")
plan = rospy.ServiceProxy("add_two_poses", GetPlan, persistent=True)
for number in range(3):
    request = GetPlanRequest(tolerance=0.5)
    request.start.header.frame_id, request.goal.header.frame_id = "map", "odom"
    request.start.pose.position.x, request.goal.pose.position.x = number, 10
    answer = plan(request)
    print(answer.plan.header.frame_id, [pose.pose.position.x for pose in answer.plan.poses])
plan.close()
judge = rospy.ServiceProxy("judge", SetBool)
print(judge(True), judge(data=True).message, judge.call(SetBoolRequest(True)).success)
print(rospy.ServiceProxy("dict", Trigger)())
for name in ("judge", "nothing", "missing"):
    try:
        rospy.ServiceProxy(name, SetBool)(False)
    except rospy.ServiceException as error:
        print(name, type(error).__name__, error)
try:
    judge("text")
except rospy.ServiceException as error:
    print("text", error)
except Exception as error:
    print("text", type(error).__name__)
try:
    rospy.wait_for_service("missing", timeout=0.2)
except rospy.ROSException as error:
    print(error)
try:
    rospy.ServiceProxy("end", Empty)()
except rospy.ServiceException:
    pass  # the server may end before its answer is out
"""
    out = same_in_all_pairs(launcher, server, client)
    assert "mapodom [12.0, 10.0]" in out and "service [/missing] unavailable" in out


def test_headers(launcher: Master) -> None:
    sender = """
from geometry_msgs.msg import Point, PointStamped
from std_msgs.msg import Header
pub = rospy.Publisher("points", PointStamped, queue_size=10)
connected(pub)
before = rospy.Time.now()
pub.publish(None, Point(1, 2, 3))                                   # the header is filled in
pub.publish(Header(stamp=before, frame_id="given", seq=77), Point(4, 5, 6))
pub.publish(header=Header(frame_id="named"), point=Point(z=7))
pub.publish(PointStamped(Header(0, rospy.Time(5, 6), "whole"), Point()))
while_heard(pub)
print("finished")
"""
    receiver = """
from geometry_msgs.msg import PointStamped
heard = []
def callback(data, args):
    heard.append(data)
    now = rospy.Time.now()
    recent = now - data.header.stamp < rospy.Duration(60)
    stamp = "recent" if recent else (data.header.stamp.secs, data.header.stamp.nsecs)
    print(args, data.header.seq, data.header.frame_id, stamp, data.point.x, data.point.y, data.point.z)
    if len(heard) == 4:
        rospy.signal_shutdown("enough")
rospy.Subscriber("points", PointStamped, callback, ["extra"])
rospy.spin()
"""
    out = same_in_all_pairs(launcher, sender, receiver)
    assert "['extra'] 2 given recent 4.0 5.0 6.0" in out and "4 whole (5, 6)" in out


def test_connection_headers(launcher: Master) -> None:
    sender = """
from std_msgs.msg import String
from std_srvs.srv import Trigger
pub = rospy.Publisher("snacks", String, headers={"cookies": "oreo"}, queue_size=1, latch=True)
pub.publish("yum")
def answer(req):
    header = req._connection_header
    return True, " ".join(header.get(each, "-") for each in ("callerid", "cookies", "service", "md5sum"))
connected(pub)
rospy.Service("eat", Trigger, answer)  # for which the subscriber waits before it leaves
while_heard(pub)
print("finished")
"""
    receiver = """
from std_msgs.msg import String
from std_srvs.srv import Trigger
said = []
def callback(data):
    header = data._connection_header
    said.extend(header.get(each, "-") for each in ("callerid", "cookies", "topic", "type", "md5sum", "latching"))
subscriber = rospy.Subscriber("snacks", String, callback)
while len(said) < 6 and not rospy.is_shutdown():
    rospy.sleep(0.01)
print(said)
rospy.wait_for_service("eat")
print(rospy.ServiceProxy("eat", Trigger, headers={"cookies": "peanut"})().message)
subscriber.unregister()
"""
    out = same_in_all_pairs(launcher, sender, receiver)
    assert "'/first', 'oreo', '/snacks', 'std_msgs/String'" in out and "/second peanut" in out


def test_parameters(launcher: Master) -> None:
    setter = """
from std_msgs.msg import Empty
rospy.set_param("/tutorial", {"gains": {"p": 1, "i": 2.5}, "list": ["a", 3, True], "name": "x"})
rospy.set_param("tutorial/bool", False)
rospy.set_param("~private", 7)
rospy.set_param("/tutorial/first/deep", 1)
rospy.set_param("/seen", False)
done = rospy.Publisher("parameters_set", Empty, latch=True, queue_size=1)
done.publish()
while not rospy.get_param("/seen"):  # the other program may come and go between two looks at the connections
    rospy.sleep(0.01)
print(rospy.has_param("/tutorial/name"), rospy.get_param("/tutorial/gains"))
print("finished")
"""
    getter = """
from std_msgs.msg import Empty
hear = rospy.Subscriber("parameters_set", Empty, lambda message: None)
rospy.wait_for_message("parameters_set", Empty)
print(rospy.get_param("/tutorial/gains/p"), sorted(rospy.get_param("tutorial").items(), key=str))
print(rospy.get_param("/first/private"), rospy.get_param("~mine"), rospy.get_param("~mine", 9))
print(rospy.get_param("missing", "default"), rospy.has_param("missing"), rospy.search_param("tutorial/gains"))
for call in (rospy.get_param, rospy.delete_param):
    try:
        call("missing")
    except KeyError as error:
        print("KeyError", error)
print(sorted(name for name in rospy.get_param_names() if name.startswith("/tutorial/")))
print(rospy.get_param_cached("/tutorial/bool"))
rospy.delete_param("/tutorial/name")
rospy.set_param("/tutorial/gains/p", 5)
print(rospy.get_param("/tutorial/gains"), sys.argv, rospy.myargv(), rospy.resolve_name("~a"), rospy.resolve_name("b"))
rospy.delete_param("~mine")
rospy.set_param("/seen", True)
"""
    arguments = ("_mine:=[1, two]", "b:=/c", "word")
    out = same_in_all_pairs(
        launcher, setter, getter.replace("sys.argv, ", "").replace("rospy.myargv()", "rospy.myargv()[1:]"), *arguments
    )
    assert "7 [1, 'two'] [1, 'two']" in out and "{'p': 5, 'i': 2.5} ['word'] /second/a /c" in out


def test_numpy(launcher: Master) -> None:
    sender = """
from rospy.numpy_msg import numpy_msg
from sensor_msgs.msg import JointState
pub = rospy.Publisher("floats", numpy_msg(JointState), queue_size=10)
connected(pub)
pub.publish(None, ["a", "b"], numpy.array([1.0, 2.1]), numpy.arange(3, dtype=numpy.float64), numpy.array([]))
pub.publish(JointState(position=numpy.linspace(0, 1, 5)))
while_heard(pub)
print("finished")
"""
    receiver = """
from rospy.numpy_msg import numpy_msg
from sensor_msgs.msg import JointState
count = []
def callback(data):
    print(data.name, type(data.position).__name__, data.position.dtype, data.position.tolist(), data.velocity.sum(),
          data.effort.shape)
    count.append(1)
    if len(count) == 2:
        rospy.signal_shutdown("enough")
rospy.Subscriber("floats", numpy_msg(JointState), callback)
rospy.spin()
"""
    out = same_in_all_pairs(launcher, sender, receiver)
    assert "['a', 'b'] ndarray float64 [1.0, 2.1] 3.0 (0,)" in out


def test_timers_waits_and_ends(launcher: Master) -> None:
    sender = """
from std_msgs.msg import Int32
pub = rospy.Publisher("ticks", Int32, queue_size=10)
once = []
seen = []
def tick(event):
    kinds = {type(each).__name__ for each in (event.current_real, event.current_expected, event.last_real) if each}
    if len(seen) < 3:
        seen.append((sorted(kinds), event.last_real is None, event.last_duration is None))
    pub.publish(len(seen))
timer = rospy.Timer(rospy.Duration(0.01), tick)
rospy.Timer(rospy.Duration(0.01), lambda event: once.append(event.last_real), oneshot=True)
connected(pub)
while_heard(pub)
timer.shutdown()
timer.join()
print(seen, once)
rospy.on_shutdown(lambda: print("one"))
rospy.on_shutdown(lambda: print("two", rospy.is_shutdown()))
rospy.signal_shutdown("over")
print(rospy.is_shutdown())
rospy.on_shutdown(lambda: print("late"))
print("finished")
"""
    receiver = """
from std_msgs.msg import Int32
hear = rospy.Subscriber("ticks", Int32)
print(type(rospy.wait_for_message("ticks", Int32, timeout=20).data).__name__)
while rospy.wait_for_message("ticks", Int32, rospy.Duration(20)).data < 3:
    pass
try:
    rospy.wait_for_message("silence", Int32, timeout=0.1)
except rospy.ROSException as error:
    print(error)
"""
    out = same_in_all_pairs(launcher, sender, receiver)
    assert (
        "one\ntwo False\nTrue\nlate\n" in out and "timeout exceeded while waiting for message on topic silence" in out
    )


def test_camera_synchronizer(launcher: Master) -> None:
    camera = """
from sensor_msgs.msg import CameraInfo, Image
image_pub = rospy.Publisher("image", Image, queue_size=20)
info_pub = rospy.Publisher("camera_info", CameraInfo, queue_size=20)
connected(image_pub, info_pub)
for number in range(10):
    image = Image(height=2, width=3, encoding="rgb8", step=9, data=bytes([number] * 18))
    info = CameraInfo(height=2, width=3, distortion_model="plumb_bob", K=[float(number)] * 9)
    image.header.stamp = info.header.stamp = rospy.Time(100 + number)
    if number % 3 == 1:
        info.header.stamp += rospy.Duration(0.02)
    image_pub.publish(image)
    info_pub.publish(info)
while_heard(image_pub)
while_heard(info_pub)
print("finished")
"""
    viewer = """
import threading
import message_filters
from sensor_msgs.msg import CameraInfo, Image
exact, near = [], []
lock = threading.Lock()
def show(image, info, found):
    with lock:
        found.append((image.header.stamp.secs, info.header.stamp.to_sec(), len(image.data), image.data[0], info.K[8]))
        if exact and near and exact[-1][0] == near[-1][0] == 109:
            rospy.signal_shutdown("enough")
image_sub = message_filters.SimpleFilter()
info_sub = message_filters.SimpleFilter()
message_filters.TimeSynchronizer([image_sub, info_sub], 20).registerCallback(show, exact)
message_filters.ApproximateTimeSynchronizer([image_sub, info_sub], 20, 0.05).registerCallback(show, near)
subscribers = [rospy.Subscriber("image", Image, image_sub.signalMessage),
               rospy.Subscriber("camera_info", CameraInfo, info_sub.signalMessage)]
rospy.spin()
print(sorted(exact))
print(sorted(near))
"""
    out = same_in_all_pairs(launcher, camera, viewer)
    assert "(101, 101.02, 18, 1, 1.0)" in out


def test_latched_map(launcher: Master) -> None:
    server = """
from geometry_msgs.msg import Quaternion
from nav_msgs.msg import MapMetaData, OccupancyGrid
pub = rospy.Publisher("map", OccupancyGrid, latch=True, queue_size=1)
grid = OccupancyGrid(info=MapMetaData(resolution=0.05, width=100, height=80))
grid.header.frame_id = "map"
grid.info.origin.orientation = Quaternion(0, 0, 0.6, 0.8)
grid.data = [-1] * 7900 + list(range(100))
pub.publish(OccupancyGrid())
pub.publish(grid)
while not rospy.has_param("/map_seen"):
    rospy.sleep(0.05)
rospy.delete_param("/map_seen")
print("finished")
"""
    client = """
from nav_msgs.msg import OccupancyGrid
for _ in range(2):
    grid = rospy.wait_for_message("map", OccupancyGrid, 20)
    print(grid.info.width, grid.info.height, round(grid.info.resolution, 4), len(grid.data), sum(grid.data))
raw = rospy.wait_for_message("map", rospy.AnyMsg, 20)
print(raw._connection_header["type"], len(raw._buff))
again = OccupancyGrid().deserialize(raw._buff)
again.header.seq = grid.header.seq  # stock counts latched messages that it sends again
print(again == grid, again.info.origin.orientation)
rospy.set_param("/map_seen", True)
"""
    out = same_in_all_pairs(launcher, server, client)
    assert "100 80 0.05 8000" in out
