"""robot_localization: estimates a robot's pose from odometry, IMUs and GPS (https://wiki.ros.org/robot_localization).

``ekf_node``, ``ukf_node`` and ``navsat_node`` are the programs; ``frames`` looks up the sensors' frames with tf. All
other modules are pure.
"""
