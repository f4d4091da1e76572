"""tf2_ros, by pyros1: frames over time, with topics and conversions (https://wiki.ros.org/tf2_ros)."""

import threading

import rospy
from tf2_py import (
    BufferCore,
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TimeoutException,
    TransformException,
)

from pyros1.msgs.actionlib_msgs.msg import GoalStatus
from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.std_msgs.msg import Header
from pyros1.msgs.tf2_msgs.msg import LookupTransformAction, LookupTransformGoal, TFMessage
from pyros1.msgs.tf2_msgs.srv import FrameGraph, FrameGraphResponse
from tf2_ros.buffer import DEFAULT_CAN_TRANSFORM_POLLING_SCALE, Buffer
from tf2_ros.buffer_client import BufferClient
from tf2_ros.buffer_interface import (
    BufferInterface,
    ConvertRegistration,
    NotImplementedException,
    Stamped,
    TransformRegistration,
    TypeException,
    convert,
)
from tf2_ros.static_transform_broadcaster import StaticTransformBroadcaster
from tf2_ros.transform_broadcaster import TransformBroadcaster
from tf2_ros.transform_listener import TransformListener
