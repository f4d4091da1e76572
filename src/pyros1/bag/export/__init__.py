"""Converts bags to files for other programs: pictures, videos, MCAP, ROS 2 bags; and the last two to bags."""
