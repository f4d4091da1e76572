"""Pairs of ROS 1 and ROS 2 types: those that were found, and those of mapping files."""
