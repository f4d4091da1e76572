"""Pairs ROS 1 and ROS 2 types, using the known definitions and mapping files."""
