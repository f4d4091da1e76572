#!/usr/bin/env python3
"""Thins out point clouds with numpy: removes the floor and keeps one point per cube of space.

pyros1 run my_package cloud_filter.py            receives clouds on points, publishes on filtered
pyros1 run my_package cloud_filter.py _floor:=0.1 _cube:=0.2
pyros1 run my_package cloud_source.py            publishes clouds if you have no camera
"""

import numpy

import pyros1
from pyros1.msgs.sensor_msgs.msg import PointCloud2

NUMPY_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}  # by PointField's datatype


def records(cloud):
    """Return the points as an array with a column for each of the cloud's fields."""
    byte_order = ">" if cloud.is_bigendian else "<"
    layout = {
        "names": [field.name for field in cloud.fields],
        "formats": [
            (byte_order + NUMPY_TYPES[field.datatype], (field.count,) if field.count > 1 else ())
            for field in cloud.fields
        ],
        "offsets": [field.offset for field in cloud.fields],
        "itemsize": cloud.point_step,
    }
    return numpy.frombuffer(cloud.data, numpy.dtype(layout), count=cloud.width * cloud.height)


def on_cloud(cloud):
    points = records(cloud)
    positions = numpy.column_stack([points[axis] for axis in "xyz"])
    is_above_floor = numpy.isfinite(positions).all(axis=1) & (positions[:, 2] > floor)
    _, first_in_cube = numpy.unique((positions[is_above_floor] // cube).astype(int), axis=0, return_index=True)
    kept_points = points[is_above_floor][first_in_cube]
    # Same fields, fewer points. Keep the header: it contains the measurement's time and frame.
    cloud.height, cloud.width, cloud.row_step = 1, len(kept_points), kept_points.nbytes
    cloud.is_dense, cloud.data = True, kept_points.tobytes()
    publisher.publish(cloud)
    node.log.debug("%d of %d points", len(kept_points), len(points))


with pyros1.Node("cloud_filter") as node:
    floor = node.params.get("~floor", 0.05)  # m
    cube = node.params.get("~cube", 0.1)  # m, side length
    publisher = node.advertise("filtered", PointCloud2, queue_size=1)
    node.subscribe("points", PointCloud2, on_cloud, queue_size=1)  # only the newest cloud if clouds arrive too fast
    node.spin()
