"""Robot libraries: interactive markers, cv_bridge, diagnostics, reconfigure, topic_tools, tf."""

import inspect
import re
import sys
import numpy as np
import rospy
from geometry_msgs.msg import Pose
from std_msgs.msg import Header, String
from visualization_msgs.msg import (
    InteractiveMarker,
    InteractiveMarkerControl,
    InteractiveMarkerFeedback,
    InteractiveMarkerInit,
    InteractiveMarkerUpdate,
    MenuEntry,
    Marker,
)
import interactive_markers.interactive_marker_server as ims
import interactive_markers.menu_handler as menus
from interactive_markers.interactive_marker_server import InteractiveMarkerServer
from interactive_markers.menu_handler import MenuHandler


def t(title, call, *arguments, **named):
    try:
        found = str(call(*arguments, **named))
    except Exception as error:
        found = f"{type(error).__name__}: {error}"
    print(title, re.sub(r" at 0x[0-9a-f]+|secs: [1-9][0-9]*|nsecs: [0-9]+", "", found).replace("\n", "|"), flush=True)


rospy.init_node("names", anonymous=True)
# contexts
m = ims.MarkerContext()
u = ims.UpdateContext()
t("m", lambda: {k: type(v).__name__ for k, v in sorted(vars(m).items())})
t("u", lambda: {k: str(v).replace("\n", "|")[:60] for k, v in sorted(vars(u).items())})
print(ims.UpdateContext.FULL_UPDATE, ims.UpdateContext.POSE_UPDATE, ims.UpdateContext.ERASE)
server = InteractiveMarkerServer("space")
marker = InteractiveMarker(name="a")
marker.header.frame_id = "f"
marker.controls.append(InteractiveMarkerControl(name="c"))
calls = []


def cb(f):
    calls.append((f.marker_name, f.event_type))


t("insert", server.insert, marker, cb)
t("get", server.get, "a")
t("apply", server.applyChanges)
t("get", lambda: server.get("a").name)
t("get", server.get, "zz")
t("pose", server.setPose, "a", Pose())
t("pose", server.setPose, "zz", Pose())
t("erase", server.erase, "zz")
p = Pose()
p.position.x = 5.0
ctx = u
h = Header(frame_id="other")
t("doSetPose", server.doSetPose, None, "a", p, h)
t("get", lambda: (server.get("a").pose.position.x, server.get("a").header.frame_id))
up = ims.UpdateContext()
up.int_marker = InteractiveMarker(name="a")
up.update_type = ims.UpdateContext.FULL_UPDATE
t("doSetPose", server.doSetPose, up, "a", p, Header(frame_id="x"))
t(
    "up",
    lambda: (
        up.update_type,
        up.int_marker.pose.position.x,
        up.int_marker.header.frame_id,
        server.get("a").header.frame_id,
    ),
)
t("empty h", server.doSetPose, None, "a", Pose(), Header())
server.applyChanges()
t("get", lambda: (server.get("a").pose.position.x, server.get("a").header.frame_id))
heard = []
sub = rospy.Subscriber("space/update", InteractiveMarkerUpdate, heard.append)
sub2 = rospy.Subscriber("space/update_full", InteractiveMarkerInit, heard.append)
t("keep", server.keepAlive)
t("keep", server.keepAlive, None)
t("init", server.publishInit)
import time

end = time.monotonic() + 30
while time.monotonic() < end and not (
    any(type(x).__name__.endswith("Init") for x in heard) and any(getattr(x, "type", None) == 0 for x in heard)
):
    server.keepAlive(None)
    time.sleep(0.05)
print(
    sorted({(type(x).__name__, getattr(x, "type", None), x.server_id.count("/")) for x in heard}),
    [len(x.markers) for x in heard if type(x).__name__.endswith("Init")][:1],
)
f = InteractiveMarkerFeedback(marker_name="a", client_id="me", event_type=InteractiveMarkerFeedback.BUTTON_CLICK)
t("process", server.processFeedback, f)
print(calls)
t("process", server.processFeedback, InteractiveMarkerFeedback(marker_name="zz"))
f2 = InteractiveMarkerFeedback(marker_name="a", client_id="me", event_type=InteractiveMarkerFeedback.POSE_UPDATE)
f2.pose.position.y = 3
f2.header.frame_id = "f"
t("process", server.processFeedback, f2)
t("pose", lambda: server.get("a").pose.position.y)
f3 = InteractiveMarkerFeedback(marker_name="a", client_id="you", event_type=InteractiveMarkerFeedback.POSE_UPDATE)
f3.pose.position.y = 9
t("process", server.processFeedback, f3)
t("pose", lambda: server.get("a").pose.position.y)
print(calls)
t("setcb", server.setCallback, "a", cb, InteractiveMarkerFeedback.MOUSE_DOWN)
t("setcb", server.setCallback, "zz", cb)
t("setcb", server.setCallback, "a", None)
t("clear", server.clear)
t("get", server.get, "a")
server.applyChanges()
t("get", server.get, "a")
# menus
print(MenuHandler.NO_CHECKBOX, MenuHandler.CHECKED, MenuHandler.UNCHECKED)
e = menus.EntryContext()
t("e", lambda: {k: str(v) for k, v in sorted(vars(e).items())})
mh = MenuHandler()
one = mh.insert("one")
two = mh.insert("two", callback=cb)
sub1 = mh.insert("sub", parent=one, command="cmd", command_type=MenuEntry.ROSRUN)
print(one, two, sub1)
t("insert", mh.insert, "bad", parent=99)
made = mh.doInsert("raw", MenuEntry.FEEDBACK, "command", cb)
print(made)
t("wrong", mh.doInsert, "x")
t("entry", mh.makeEntry, mh.entry_contexts_[one], one, 0)
t("entry", mh.makeEntry, mh.entry_contexts_[sub1], sub1, one)
for s in (MenuHandler.CHECKED, MenuHandler.UNCHECKED, MenuHandler.NO_CHECKBOX):
    t("check", mh.setCheckState, two, s)
    t("get", mh.getCheckState, two)
    t("entry", mh.makeEntry, mh.entry_contexts_[two], two, 7)
t("vis", mh.setVisible, sub1, False)
t("vis", mh.setVisible, 99, False)
t("check", mh.setCheckState, 99, 1)
t("get", mh.getCheckState, 99)
t("title", mh.getTitle, two)
t("title", mh.getTitle, 99)
out = []
t("push", mh.pushMenuEntries, [one, two], out, 3)
print([(x.id, x.parent_id, x.title, x.command, x.command_type) for x in out])
mh.setVisible(sub1, True)
out = []
t("push", mh.pushMenuEntries, [one, 99, two], out, 0)
print([(x.id, x.parent_id, x.title) for x in out])
t("push", mh.pushMenuEntries, [], [], 0)
server.insert(InteractiveMarker(name="m"))
server.applyChanges()
t("apply", mh.apply, server, "m")
server.applyChanges()
print([(x.id, x.title) for x in server.get("m").menu_entries])
t("re", mh.reApply, server)
f = InteractiveMarkerFeedback(marker_name="m", event_type=InteractiveMarkerFeedback.MENU_SELECT, menu_entry_id=two)
t("process", mh.processFeedback, f)
f.menu_entry_id = 99
t("process", mh.processFeedback, f)
print(calls)
