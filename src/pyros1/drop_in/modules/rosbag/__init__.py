"""rosbag, by pyros1: bags in Python (https://wiki.ros.org/rosbag/Code%20API)."""

from pyros1.drop_in.missing import missing
from rosbag._parts import Compression, ROSBagException, ROSBagFormatException, ROSBagUnindexedException
from rosbag.bag import Bag
from rosbag.rosbag_main import rosbagmain

__getattr__ = missing(__name__)
