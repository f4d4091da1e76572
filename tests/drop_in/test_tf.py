"""tf, tf2 and what stands on them, by pyros1, in programs as users write them."""

from __future__ import annotations

import pytest
from programs import run

WITHOUT_A_NODE = """
import math
import rospy, tf, tf2_py, tf2_ros, tf_conversions
import tf2_geometry_msgs, tf2_sensor_msgs
from geometry_msgs.msg import PointStamped, TransformStamped

def stamped(seconds, x, angle=0.0):
    it = TransformStamped()
    it.header.frame_id, it.child_frame_id, it.header.stamp = "map", "base", rospy.Time(seconds)
    it.transform.translation.x = x
    turn = tf_conversions.transformations.quaternion_from_euler(0, 0, angle)
    it.transform.rotation.z, it.transform.rotation.w = turn[2], turn[3]
    return it

buffer = tf2_ros.Buffer(debug=False)
buffer.set_transform(stamped(1, 1.0), "me")
buffer.set_transform(stamped(3, 3.0), "me")
found = buffer.lookup_transform("map", "base", rospy.Time(2))
assert found.transform.translation.x == 2.0 and type(found.header.stamp) is rospy.Time
assert buffer.can_transform("map", "nope", rospy.Time(0), return_debug_tuple=True)[0] == 0
try:
    buffer.lookup_transform("map", "base", rospy.Time(9))
except tf2_ros.ExtrapolationException as error:
    assert "into the future" in str(error)
point = PointStamped()
point.header.frame_id, point.header.stamp, point.point.y = "base", rospy.Time(3), 1.0
moved = buffer.transform(point, "map")
assert (moved.point.x, moved.point.y) == (3.0, 1.0)
try:
    buffer.lookup_transform("map", "nope", rospy.Time(0), rospy.Duration(1))
except rospy.ROSInitException as error:
    print("no node:", error)

# a frame on a circle of 2 m around the origin, at 0.5 rad/s: 1 m/s
old = tf.TransformerROS()
for step in range(20):
    angle = 0.05 * step
    it = stamped(0, 2 * math.cos(angle), angle)
    it.header.stamp, it.transform.translation.y = rospy.Time.from_sec(10 + 0.1 * step), 2 * math.sin(angle)
    old.setTransform(it)
when, span = rospy.Time.from_sec(10.95), rospy.Duration(0.1)
linear, angular = old.lookupTwist("base", "map", when, span)
assert abs(math.hypot(*linear) - 1.0) < 1e-3 and abs(angular[2] - 0.5) < 1e-9, (linear, angular)
# the center of the circle, taken as a part of the frame, stands still
still, _ = old.lookupTwistFull("base", "map", "map", (0, 0, 0), "map", when, span)
assert math.hypot(*still) < 1e-3, still
assert old.frameExists("base") and old.getFrameStrings() == ["base"]

for module, word in (("tf2_kdl", "PyKDL"), ("tf2_nothing", "tf2_nothing")):
    try:
        __import__(module)
    except ImportError as error:
        assert word in str(error)
try:
    import PyKDL
except ImportError as error:
    assert "tf2_kdl" not in str(error), error  # which needs PyKDL itself
try:
    tf.point_bt_to_msg
except AttributeError as error:
    print("gone:", error)
"""


def test_without_a_node(environ: dict[str, str]) -> None:
    said = run(WITHOUT_A_NODE, environ)
    assert "no node: time is not initialized" in said
    assert "gone: tf.point_bt_to_msg" in said


WITH_A_NODE = """
import threading
import rospy, tf, tf2_ros
from geometry_msgs.msg import TransformStamped
from tf2_msgs.srv import FrameGraph

def stamped(parent, child, x):
    it = TransformStamped()
    it.header.frame_id, it.child_frame_id, it.header.stamp = parent, child, rospy.Time.now()
    it.transform.translation.x, it.transform.rotation.w = x, 1.0
    return it

rospy.init_node("frames")
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)
taken = []

class Counting(tf2_ros.Buffer):
    def set_transform(self, transform, authority):
        taken.append((transform.child_frame_id, authority))
        tf2_ros.Buffer.set_transform(self, transform, authority)

counting = Counting()
other = tf2_ros.TransformListener(counting)
waiting = []
thread = threading.Thread(
    target=lambda: waiting.append(buffer.lookup_transform("world", "tip", rospy.Time(0), rospy.Duration(30)))
)
thread.start()
static, sender, old = tf2_ros.StaticTransformBroadcaster(), tf2_ros.TransformBroadcaster(), tf.TransformBroadcaster()
static.sendTransform(stamped("world", "base", 1.0))
static.sendTransform([stamped("base", "arm", 2.0)])
while thread.is_alive():
    sender.sendTransform([stamped("arm", "tip", 4.0)])
    old.sendTransform((1, 0, 0), (0, 0, 0, 1), rospy.Time.now(), "side", "base")
    thread.join(0.02)
print("found", waiting[0].transform.translation.x)
late = tf.TransformListener()
late.waitForTransform("/world", "/arm", rospy.Time(0), rospy.Duration(30))
print("late", late.lookupTransform("/world", "/arm", rospy.Time(0))[0])
assert counting.can_transform("world", "arm", rospy.Time(0), rospy.Duration(30))
assert ("tip", "/frames") in taken or counting.can_transform("arm", "tip", rospy.Time(0), rospy.Duration(30))
assert "base:" in rospy.ServiceProxy("~tf2_frames", FrameGraph)().frame_yaml
start = rospy.Time.now()
try:
    late.waitForTransform("world", "nowhere", rospy.Time(0), rospy.Duration(0.1))
except tf.Exception as error:
    print("waited:", error)
assert rospy.Time.now() - start >= rospy.Duration(0.1)
client = tf2_ros.BufferClient("nothing", timeout_padding=rospy.Duration(0.1))
try:
    client.lookup_transform("a", "b", rospy.Time(0))
except tf2_ros.TimeoutException as error:
    print("client:", error)
ended = threading.Thread(target=lambda: buffer.can_transform("world", "nowhere", rospy.Time(0), rospy.Duration(60)))
ended.start()
rospy.signal_shutdown("done")
ended.join(20)
assert not ended.is_alive()
"""


@pytest.mark.slow
def test_with_a_node(environ: dict[str, str]) -> None:
    said = run(WITH_A_NODE, environ)
    assert "found 7.0" in said
    assert "late [3.0, 0.0, 0.0]" in said
    assert "waited: canTransform: source_frame nowhere does not exist." in said
    assert "client: The LookupTransform goal" in said
