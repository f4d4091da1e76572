"""Exports bags as tables, images, videos, MCAP files and ROS 2 bags; imports MCAP files and ROS 2 bags."""
