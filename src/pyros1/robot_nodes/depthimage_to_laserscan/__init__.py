"""Converts depth images to laser scans (https://wiki.ros.org/depthimage_to_laserscan)."""
