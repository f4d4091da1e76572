"""ros_numpy, by pyros1: messages as numpy arrays, and back (https://wiki.ros.org/ros_numpy)."""

from pyros1.drop_in.module_attributes import module_getattr
from ros_numpy import geometry, image, occupancy_grid, point_cloud2
from ros_numpy.registry import msgify, numpify

__getattr__ = module_getattr(__name__)
