"""pyros1: ROS 1 as a Python package."""
