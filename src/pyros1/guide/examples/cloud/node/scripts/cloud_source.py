#!/usr/bin/env python3
"""Publishes point clouds like a depth camera: a floor and a ball that bounces on it.

pyros1 run my_package cloud_source.py
pyros1 web scene --open                          displays them; select camera as the fixed frame
"""

import numpy

import pyros1
from pyros1.msgs.sensor_msgs.msg import PointCloud2, PointField

COUNT = 5000  # number of points on each object
RADIUS = 0.3  # m, of the ball
FIELDS = [PointField(name, 4 * index, PointField.FLOAT32, 1) for index, name in enumerate("xyz")]


def points(seconds, generator):
    """Return the points of the floor and the ball as an array with the columns x, y and z in m."""
    floor = numpy.column_stack([generator.uniform(-2, 2, (COUNT, 2)), numpy.zeros(COUNT)])
    ball = generator.normal(size=(COUNT, 3))
    ball *= RADIUS / numpy.linalg.norm(ball, axis=1, keepdims=True)
    ball[:, 2] += RADIUS + abs(numpy.sin(2 * seconds))
    return numpy.concatenate([floor, ball]).astype("<f4")


with pyros1.Node("cloud_source") as node:
    publisher = node.advertise("points", PointCloud2, queue_size=1)
    generator = numpy.random.default_rng()
    rate = node.rate(10.0)  # Hz
    while node.ok():
        now = node.now()
        array = points(now.to_sec(), generator)
        cloud = PointCloud2(height=1, width=len(array), fields=FIELDS, point_step=12, is_dense=True)
        cloud.header.stamp, cloud.header.frame_id = now, "camera"
        cloud.row_step, cloud.data = array.nbytes, array.tobytes()
        publisher.publish(cloud)
        rate.sleep()
