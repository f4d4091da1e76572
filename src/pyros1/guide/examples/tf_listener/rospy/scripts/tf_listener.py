#!/usr/bin/env python3
"""Prints the position of one frame relative to another.

pyros1 run my_package tf_listener.py world laser
pyros1 tf static_transform_publisher 1 0 0.5 0 0 0 world laser     publishes a frame if you have none
"""

import argparse

import rospy
import tf2_ros


def main():
    parser = argparse.ArgumentParser(description="Prints the position of one frame relative to another.")
    parser.add_argument("target", nargs="?", default="world", help="the frame in which the position is given")
    parser.add_argument("source", nargs="?", default="laser", help="the frame whose position is printed")
    frames = parser.parse_args(rospy.myargv()[1:])
    rospy.init_node("tf_listener", anonymous=True)
    buffer = tf2_ros.Buffer()
    listener = tf2_ros.TransformListener(buffer)  # noqa: F841 - it must exist to fill the buffer
    latest = rospy.Time(0)  # stands for the latest transform; a message's stamp can be used instead
    while not rospy.is_shutdown():
        try:
            transform = buffer.lookup_transform(frames.target, frames.source, latest, rospy.Duration(1.0))
        except tf2_ros.TransformException as error:
            rospy.logwarn("no position yet: %s", error)
        else:
            position = transform.transform.translation
            rospy.loginfo("%s is at x = %.2f, y = %.2f, z = %.2f m", frames.source, position.x, position.y, position.z)
        rospy.sleep(0.5)


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C during sleep
