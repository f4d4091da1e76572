#!/usr/bin/env python3
"""Prints where one frame is relative to another.

pyros1 run my_package tf_listener.py world laser
pyros1 tf static_transform_publisher 1 0 0.5 0 0 0 world laser     a frame, if nobody publishes any
"""

import argparse

import rospy
import tf2_ros


def main():
    parser = argparse.ArgumentParser(description="Prints where one frame is relative to another.")
    parser.add_argument("target", nargs="?", default="world", help="the frame in which the place is told")
    parser.add_argument("source", nargs="?", default="laser", help="the frame whose place it is")
    frames = parser.parse_args(rospy.myargv()[1:])
    rospy.init_node("tf_listener", anonymous=True)
    buffer = tf2_ros.Buffer()
    listener = tf2_ros.TransformListener(buffer)  # noqa: F841 - it fills the buffer as long as it exists
    latest = rospy.Time(0)  # the latest that there is; or the stamp of a message
    while not rospy.is_shutdown():
        try:
            found = buffer.lookup_transform(frames.target, frames.source, latest, rospy.Duration(1.0))
        except tf2_ros.TransformException as error:
            rospy.logwarn("not yet: %s", error)
        else:
            place = found.transform.translation
            rospy.loginfo("%s is at x = %.2f, y = %.2f, z = %.2f m", frames.source, place.x, place.y, place.z)
        rospy.sleep(0.5)


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C, while it slept
