#!/usr/bin/env python3
"""Publishes point clouds like a depth camera: a floor and a ball that bounces on it.

pyros1 run my_package cloud_source.py
pyros1 web scene --open                          displays them; select camera as the fixed frame
"""

import numpy
import rospy
from sensor_msgs import point_cloud2
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header

COUNT = 5000  # number of points on each object
RADIUS = 0.3  # m, of the ball


def points(seconds, generator):
    """Return the points of the floor and the ball as an array with the columns x, y and z in m."""
    floor = numpy.column_stack([generator.uniform(-2, 2, (COUNT, 2)), numpy.zeros(COUNT)])
    ball = generator.normal(size=(COUNT, 3))
    ball *= RADIUS / numpy.linalg.norm(ball, axis=1, keepdims=True)
    ball[:, 2] += RADIUS + abs(numpy.sin(2 * seconds))
    return numpy.concatenate([floor, ball]).astype("<f4")


def main():
    rospy.init_node("cloud_source")
    publisher = rospy.Publisher("points", PointCloud2, queue_size=1)
    generator = numpy.random.default_rng()
    rate = rospy.Rate(10.0)  # Hz
    while not rospy.is_shutdown():
        header = Header(stamp=rospy.Time.now(), frame_id="camera")
        array = points(header.stamp.to_sec(), generator)
        publisher.publish(point_cloud2.create_cloud_xyz32(header, array))
        rate.sleep()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C during sleep
