"""Converts bags to pictures, videos, MCAP files and ROS 2 bags, and the last two to bags."""
