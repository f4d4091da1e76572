"""tf2_sensor_msgs, by pyros1: transforms point clouds to other frames (https://wiki.ros.org/tf2_sensor_msgs).

Importing this module registers point clouds for `tf2_ros.Buffer.transform`.
"""

import rospy

from tf2_sensor_msgs.tf2_sensor_msgs import (
    PointCloud2,
    __getattr__,
    do_transform_cloud,
    from_msg_msg,
    to_msg_msg,
    transform_to_kdl,
)
