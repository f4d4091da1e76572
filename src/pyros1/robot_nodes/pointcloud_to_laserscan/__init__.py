"""Converts point clouds to laser scans and back (https://wiki.ros.org/pointcloud_to_laserscan)."""
