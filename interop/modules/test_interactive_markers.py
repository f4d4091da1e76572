"""interactive_markers of stock and ours: the same calls and feedback, the same messages; and a client of the other kind."""

from __future__ import annotations

import pytest
from faces import same, start
from harness import Master

START = """
import rospy
from geometry_msgs.msg import Point, Pose, Quaternion
from interactive_markers.interactive_marker_server import *
from interactive_markers.menu_handler import *
from std_msgs.msg import Header
from visualization_msgs.msg import *

def marker(name, x=0.0, stamp=0):
    it = InteractiveMarker()
    it.name, it.pose.position.x, it.header.frame_id, it.header.stamp = name, x, "map", rospy.Time(stamp)
    return it

def feedback(name, kind, client="one", x=0.0, entry=0):
    it = InteractiveMarkerFeedback(marker_name=name, event_type=kind, client_id=client, menu_entry_id=entry)
    it.pose.position.x, it.header.frame_id, it.header.stamp = x, "odom", rospy.Time(7)
    return it
"""

CALLS = (
    START
    + """
def place(it):
    return (it.name, it.header.frame_id, it.header.stamp.secs, it.pose.position.x)

def entries(menu):
    return [(entry.id, entry.parent_id, entry.title, entry.command, entry.command_type) for entry in menu]

class Updates:
    def publish(self, it):
        if it.type != it.KEEP_ALIVE:
            print("update", it.server_id, it.seq_num, [place(m) + (entries(m.menu_entries),) for m in it.markers],
                  [place(pose) for pose in it.poses], it.erases)

class Inits:
    def publish(self, it):
        print("init", it.server_id, it.seq_num, sorted(map(place, it.markers)))

def say(label, ask, *arguments):
    try:
        print(label, ask(*arguments))
    except Exception as error:
        print(label, type(error).__name__, error)

def where(name):
    it = server.get(name)
    print("get", name, it and place(it))

def apply():
    # the markers then belong to the client named one, who would else wait for a second
    server.applyChanges()
    for context in server.marker_contexts.values():
        context.last_client_id = "one"

rospy.init_node("markers")
server = InteractiveMarkerServer("marks")
other = InteractiveMarkerServer("others", "second", 5)
print(server.server_id, other.server_id, server.topic_ns, server.seq_num, server.DEFAULT_FEEDBACK_CB)
server.update_pub, server.init_pub = Updates(), Inits()
got = lambda it: print("got", it.event_type, it.client_id)
say("insert", server.insert, marker("a", 1.0, 3), got)
where("a")
apply()
where("a")
where("none")
say("nothing to apply", server.applyChanges)
pose = Pose(Point(5.0, 0, 0), Quaternion(0, 0, 0, 1))
say("pose", server.setPose, "a", pose)
where("a")
apply()
say("pose of none", server.setPose, "none", pose)
say("pose", server.setPose, "a", Pose(Point(6.0, 0, 0), Quaternion()), Header(0, rospy.Time(9), "odom"))
apply()
say("callback", server.setCallback, "a", lambda it: print("click", it.event_type), InteractiveMarkerFeedback.BUTTON_CLICK)
say("callback of none", server.setCallback, "none", got)
for kind in range(7):
    server.processFeedback(feedback("a", kind, "one", float(kind)))
    where("a")
server.marker_contexts["a"].last_feedback = rospy.Time.now() + rospy.Duration(60)  # the second is not over, however slow this is
server.processFeedback(feedback("a", InteractiveMarkerFeedback.POSE_UPDATE, "two", 70.0))
server.processFeedback(feedback("none", InteractiveMarkerFeedback.POSE_UPDATE))
where("a")
apply()
say("insert", server.insert, marker("fixed", 2.0), got)
apply()
server.processFeedback(feedback("fixed", InteractiveMarkerFeedback.POSE_UPDATE, "one", 4.0))
apply()
say("callback", server.setCallback, "fixed", None)
say("erase", server.erase, "a")
where("a")
say("erase none", server.erase, "none")
apply()
say("insert", server.insert, marker("b"))
say("insert", server.insert, marker("b", 3.0))
say("pose of a new one", server.setPose, "b", pose)
apply()
say("insert", server.insert, marker("b", 4.0))
say("pose", server.setPose, "b", pose)
where("b")
say("erase", server.erase, "b")
say("insert", server.insert, marker("b", 5.0))
apply()
say("pose", server.setPose, "b", pose)
say("erase", server.erase, "b")
say("insert", server.insert, marker("c"))
say("clear", server.clear)
apply()

menu = MenuHandler()
one = menu.insert("one", callback=lambda it: print("one", it.menu_entry_id))
two = menu.insert("two")
sub = menu.insert("sub", parent=two, callback=lambda it: print("sub", it.menu_entry_id))
print(one, two, sub)
say("no parent", menu.insert, "x", 77)
say("checked", menu.setCheckState, one, MenuHandler.CHECKED)
say("unchecked", menu.setCheckState, two, MenuHandler.UNCHECKED)
say("checked none", menu.setCheckState, 99, 1)
for handle in (one, two, sub, 99):
    say("state", menu.getCheckState, handle)
    say("title", menu.getTitle, handle)
say("hide", menu.setVisible, sub, False)
say("hide none", menu.setVisible, 99, False)
say("insert", server.insert, marker("m"))
say("apply menu", menu.apply, server, "m")
apply()
say("show", menu.setVisible, sub, True)
menu.insert("last", command_type=MenuEntry.ROSRUN, command="rviz rviz")
say("again", menu.reApply, server)
apply()
for entry in (one, sub, 55):
    server.processFeedback(feedback("m", InteractiveMarkerFeedback.MENU_SELECT, "one", 0.0, entry))
server.clear()
apply()
"""
)

SERVER = (
    START
    + """
rospy.init_node("markers")
server = InteractiveMarkerServer("marks")
menu = MenuHandler()
menu.insert("go", callback=lambda it: (print("go", it.client_id, flush=True), rospy.signal_shutdown("done")))
server.insert(marker("a", 1.0), lambda it: print("moved", it.pose.position.x, flush=True))
menu.apply(server, "a")
server.applyChanges()
server.marker_contexts["a"].last_client_id = "me"
rospy.spin()
"""
)

CLIENT = (
    START
    + """
import threading
rospy.init_node("client")
alive, full = threading.Event(), []
there = threading.Event()
rospy.Subscriber("marks/update", InteractiveMarkerUpdate, lambda it: alive.set())
rospy.Subscriber("marks/update_full", InteractiveMarkerInit, lambda it: (full.append(it), it.markers and there.set()))
back = rospy.Publisher("marks/feedback", InteractiveMarkerFeedback, queue_size=5)
assert alive.wait(20) and there.wait(20)
it = full[-1]
print(it.server_id, it.seq_num, it.markers[0].name, it.markers[0].menu_entries[0].title, flush=True)
while not back.get_num_connections() and not rospy.is_shutdown():
    rospy.sleep(0.02)
back.publish(feedback("a", InteractiveMarkerFeedback.POSE_UPDATE, "me", 8.0))
back.publish(feedback("a", InteractiveMarkerFeedback.MENU_SELECT, "me", 8.0, 1))
rospy.spin()
"""
)


def test_calls_and_feedback(launcher: Master) -> None:
    said = same(launcher, CALLS)
    assert "sub 3" in said and "update /markers" in said


@pytest.mark.parametrize("pair", [("ours", "stock"), ("stock", "ours")], ids="-".join)
def test_a_client_of_the_other_kind(launcher: Master, pair: tuple[str, str]) -> None:
    server, client = (start(face, launcher, text) for face, text in zip(pair, (SERVER, CLIENT), strict=True))
    client.wait_line("^/markers 1 a go$")
    server.wait_line("^moved 8.0$")
    server.wait_line("^go me$")


PARTS = (
    START
    + """
import time
rospy.init_node("parts")
for name in ("logdebug", "logwarn", "logerr"):
    setattr(rospy, name, lambda text, *args, name=name: print("   ", name, text % args if args else text))
def attempt(ask, *arguments, **names):
    try:
        print("  ->", str(ask(*arguments, **names)).replace("\\\\n", " "))
    except Exception as error:
        print("  raises", type(error).__name__)
class Topic:
    def __init__(self, name):
        self.name = name
    def publish(self, message):
        if self.name != "quiet":
            print("    publishes", self.name, message.server_id, message.seq_num, getattr(message, "type", None))
server = InteractiveMarkerServer(topic_ns="marks", server_id="/own", q_size=5)
server.update_pub = server.init_pub = Topic("quiet")
def show(context):
    print("   =", getattr(context, "update_type", None), context.default_feedback_cb is None, sorted(context.feedback_cbs),
          context.int_marker.name, context.int_marker.pose.position.x, getattr(context, "last_client_id", None))
def nothing(it):
    pass
show(MarkerContext())
show(UpdateContext())
print(UpdateContext.FULL_UPDATE, UpdateContext.POSE_UPDATE, UpdateContext.ERASE, server.DEFAULT_FEEDBACK_CB)
attempt(server.insert, marker("a"), feedback_cb=len, feedback_type=255)
server.pending_updates["a"].default_feedback_cb = nothing  # without one, stock raises TypeError at feedback
attempt(server.insert, marker("a"), max, 3)
show(server.pending_updates["a"])
attempt(server.setPose, "a", Pose())
attempt(server.applyChanges)
show(server.marker_contexts["a"])
attempt(server.doSetPose, None, "a", Pose(Point(4, 5, 6), Quaternion()), Header(frame_id="f"))
show(server.pending_updates["a"])
attempt(server.doSetPose, server.pending_updates["a"], "a", Pose(Point(7, 5, 6), Quaternion()), Header(frame_id="g"))
show(server.pending_updates["a"])
attempt(server.erase, "a")
attempt(server.setPose, name="a", pose=Pose(), header=Header())
show(server.pending_updates["a"])
attempt(server.applyChanges)
context = server.marker_contexts["a"]
def feed(client, x, seconds=-60, kind=InteractiveMarkerFeedback.POSE_UPDATE):
    context.last_feedback = rospy.Time.now() - rospy.Duration(seconds)  # in the future: no second is over, however slow this is
    attempt(server.processFeedback, feedback("a", kind, client, x))
    print("   ", repr(context.last_client_id), context.int_marker.pose.position.x, sorted(server.pending_updates))
feed("one", 1.0)
feed("one", 2.0, 30)
feed("two", 3.0)
feed("one", 4.0)
feed("two", 5.0, 30)
def wrong(it):
    raise ValueError("wrong")
attempt(server.setCallback, name="a", feedback_cb=wrong, feedback_type=InteractiveMarkerFeedback.BUTTON_CLICK)
feed("two", 6.0, kind=InteractiveMarkerFeedback.BUTTON_CLICK)
attempt(server.setCallback, "a", lambda it: (print("    locked", server.mutex.locked()), server.setPose("a", Pose())))
feed("two", 7.0)
server.update_pub, server.init_pub = Topic("update"), Topic("init")
attempt(server.publish, InteractiveMarkerUpdate())
attempt(server.keepAlive, None)
attempt(server.publishInit)
attempt(server.clear)
print(sorted(server.pending_updates), sorted(server.marker_contexts))
attempt(server.applyChanges)
print(sorted(server.pending_updates), sorted(server.marker_contexts), server.seq_num)
attempt(server.insert, "no marker")
server.update_pub = server.init_pub = Topic("quiet")
"""
)


def test_contexts_and_conflicts(launcher: Master) -> None:
    assert "conflicting feedback" in same(launcher, PARTS)
