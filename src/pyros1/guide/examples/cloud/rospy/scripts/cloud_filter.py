#!/usr/bin/env python3
"""Thins out point clouds with numpy: removes the floor and keeps one point per cube of space.

pyros1 run my_package cloud_filter.py            receives clouds on points, publishes on filtered
pyros1 run my_package cloud_filter.py _floor:=0.1 _cube:=0.2
pyros1 run my_package cloud_source.py            publishes clouds if you have no camera
"""

import numpy
import rospy
from sensor_msgs import point_cloud2
from sensor_msgs.msg import PointCloud2


class Filter:
    """Publishes the filtered points of each received cloud.

    Args:
        floor: the height of the floor in m.
        cube: the length of a cube's side in m.
    """

    def __init__(self, floor, cube):
        self.floor = floor
        self.cube = cube
        self.publisher = rospy.Publisher("filtered", PointCloud2, queue_size=1)
        # Only the newest cloud if clouds arrive too fast; buff_size must be large enough for a whole cloud.
        rospy.Subscriber("points", PointCloud2, self.on_cloud, queue_size=1, buff_size=2**24)

    def on_cloud(self, cloud):
        valid_points = point_cloud2.read_points(cloud, ("x", "y", "z"), skip_nans=True)
        points = numpy.array(list(valid_points), dtype=float).reshape(-1, 3)
        points_above_floor = points[points[:, 2] > self.floor]
        _, first_in_cube = numpy.unique((points_above_floor // self.cube).astype(int), axis=0, return_index=True)
        # Keep the header: it contains the measurement's time and frame.
        self.publisher.publish(point_cloud2.create_cloud_xyz32(cloud.header, points_above_floor[first_in_cube]))
        rospy.logdebug("%d of %d points", len(first_in_cube), len(points))


if __name__ == "__main__":
    rospy.init_node("cloud_filter")
    cloud_filter = Filter(rospy.get_param("~floor", 0.05), rospy.get_param("~cube", 0.1))
    rospy.spin()
