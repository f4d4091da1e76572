"""``pyros1 bridge ros2``: exchanges topics, services and actions with ROS 2."""
