"""Turtles that drive about and draw, for those who learn ROS (https://wiki.ros.org/turtlesim)."""
