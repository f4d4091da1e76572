"""Asks a buffer server with stock's tf2_ros.BufferClient: `tf_asking.py ACTION`; prints one line per answer.

Run by the system's Python.
"""

import sys

import rospy
import tf2_ros

rospy.init_node("asking", anonymous=True)
client = tf2_ros.BufferClient(sys.argv[1], timeout_padding=rospy.Duration(20))  # 2 s are too few for a busy machine
assert client.wait_for_server(rospy.Duration(20))
simple = client.client
if hasattr(simple, "action_client"):  # stock's: it loses a result that comes before send_goal has returned
    send = simple.send_goal

    def send_goal(*args, **names):
        with simple.action_client.manager.list_mutex:
            send(*args, **names)

    simple.send_goal = send_goal
ZERO = rospy.Time()


def answer(question, *args):
    """Print what comes of a question."""
    try:
        found = question(*args)
        if not isinstance(found, bool):
            place = found.transform.translation
            found = (found.header.frame_id, found.child_frame_id, str(found.header.stamp), place.x, place.y, place.z)
        print(found, flush=True)
    except tf2_ros.TransformException as error:
        print(type(error).__name__, error, flush=True)


while not client.can_transform("map", "base", ZERO, rospy.Duration(0.5)):
    pass  # it has not heard of the frames yet, or has not seen who listens to its results
for source in ("base", "none", "island", "", "/base"):
    answer(client.lookup_transform, "map", source, ZERO)
    answer(client.can_transform, "map", source, ZERO, rospy.Duration(0.1))
answer(client.lookup_transform, "map", "base", rospy.Time(5), rospy.Duration(0.1))
answer(client.lookup_transform_full, "base", ZERO, "lidar", ZERO, "map")
answer(client.lookup_transform_full, "base", ZERO, "lidar", ZERO, "none", rospy.Duration(0.1))
