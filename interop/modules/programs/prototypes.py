"""The tool rosmsg-proto, empty messages as YAML; and the help of rosmsg."""

from collections import OrderedDict

import rosmsg
import yaml

WORDS = """
msg std_msgs/Header|-x stamp,position msg geometry_msgs/Pose|-H msg geometry_msgs/PoseStamped|nono Pose|msg
-p p: -s msg geometry_msgs/PoseArray|srv std_srvs/SetBool|-e msg geometry_msgs/PoseArray|-s msg nono/X|msg -s|msg a b
-f1 msg geometry_msgs/PoseStamped|-f0 msg geometry_msgs/Twist|srv std_srvs/Empty|msg std_msgs/Empty|msg no/X
msg sensor_msgs/Image|msg std_msgs/Time|msg tf2_msgs/TFMessage|-x stamp msg std_msgs/Header|srv std_srvs/No
msg -Hf0 -pA geometry_msgs/Pose|msg -f5 geometry_msgs/Pose|msg rosgraph_msgs/Log|srv nav_msgs/GetPlan|msg Pose
msg -e sensor_msgs/LaserScan|msg sensor_msgs/CameraInfo|msg diagnostic_msgs/DiagnosticArray|srv -x data std_srvs/SetBool
msg sensor_msgs/RegionOfInterest|msg std_msgs/Float64MultiArray|msg sensor_msgs/JointState|msg std_msgs/Char
msg geometry_msgs/PoseWithCovariance|msg sensor_msgs/PointCloud2|msg -f1 sensor_msgs/PointCloud2|msg nav_msgs/Odometry
-f0 msg sensor_msgs/RegionOfInterest|msg actionlib_msgs/GoalStatusArray|msg visualization_msgs/Marker|msg -fx a
msg actionlib/TestRequestAction|-e msg actionlib/TestRequestAction|msg -x header,goal actionlib/TestRequestAction
"""
for line in WORDS.strip().replace("\n", "|").split("|"):
    try:
        print(line, rosmsg.rosmsg_cmd_prototype(line.split()))
    except SystemExit as error:
        print(line, "exit code", error.code)
print(rosmsg.MAX_DEFAULT_NON_FLOW_ITEMS, rosmsg.fullusage(rosmsg.MODE_MSG), rosmsg.fullusage(rosmsg.MODE_SRV))
print(rosmsg.init_rosmsg_proto(), repr(yaml.dump(OrderedDict(b=1, a=[2]), default_flow_style=False)))
dumper = yaml.Dumper("")
node = rosmsg.represent_ordered_mapping(dumper, "tag:yaml.org,2002:map", OrderedDict(b=1, a=[2]))
print(node.tag, [(key.value, value.id) for key, value in node.value], node.flow_style)
