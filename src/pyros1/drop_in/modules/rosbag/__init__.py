"""rosbag, by pyros1: bags in Python (https://wiki.ros.org/rosbag/Code%20API)."""

from pyros1.drop_in.module_attributes import module_getattr
from rosbag._types import Compression, ROSBagException, ROSBagFormatException, ROSBagUnindexedException
from rosbag.bag import Bag
from rosbag.rosbag_main import rosbagmain

__getattr__ = module_getattr(__name__)
