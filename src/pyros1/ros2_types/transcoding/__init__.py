"""Converts encoded messages between ROS 1 and ROS 2, with functions generated for each pair of types."""
