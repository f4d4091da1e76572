"""transform_to_kdl of tf2_geometry_msgs and tf2_sensor_msgs, with a stand-in for PyKDL."""

import sys
import types

kdl = types.ModuleType("PyKDL")


class Rotation:
    @staticmethod
    def Quaternion(*words):
        return ("quaternion", *words)


kdl.Rotation = Rotation
kdl.Vector = lambda *words: ("vector", *words)
kdl.Frame = lambda *words: ("frame", *words)
sys.modules["PyKDL"] = kdl

import tf2_geometry_msgs
import tf2_sensor_msgs
from geometry_msgs.msg import TransformStamped

made = TransformStamped()
made.transform.translation.x, made.transform.translation.y, made.transform.translation.z = 1.0, 2.0, 3.0
made.transform.rotation.x, made.transform.rotation.w = 0.6, 0.8
for module in (tf2_geometry_msgs, tf2_sensor_msgs):
    print(module.transform_to_kdl(made), module.transform_to_kdl(TransformStamped()))
    for wrong in (None, 5, made.transform):
        try:
            print(module.transform_to_kdl(wrong))
        except AttributeError as error:
            print(type(error).__name__)
