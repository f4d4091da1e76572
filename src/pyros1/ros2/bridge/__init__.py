"""``pyros1 bridge ros2``: exchanges topics and services with ROS 2."""
