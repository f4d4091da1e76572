"""Depth images as laser scans (https://wiki.ros.org/depthimage_to_laserscan)."""
