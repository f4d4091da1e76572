"""Converts bags to images, videos, MCAP files and ROS 2 bags, and MCAP files and ROS 2 bags to bags."""
