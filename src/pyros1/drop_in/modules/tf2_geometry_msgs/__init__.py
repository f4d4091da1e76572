"""tf2_geometry_msgs, by pyros1: transforms geometry_msgs messages to other frames
(https://wiki.ros.org/tf2_geometry_msgs).

Importing this module registers these messages for `tf2_ros.Buffer.transform`.
"""

import copy

import rospy

from tf2_geometry_msgs.tf2_geometry_msgs import (
    PointStamped,
    PoseStamped,
    Vector3Stamped,
    WrenchStamped,
    do_transform_point,
    do_transform_pose,
    do_transform_vector3,
    do_transform_wrench,
    from_msg_msg,
    to_msg_msg,
    transform_to_kdl,
)
