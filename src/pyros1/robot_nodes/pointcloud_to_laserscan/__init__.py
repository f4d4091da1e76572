"""Point clouds as laser scans, and laser scans as point clouds (https://wiki.ros.org/pointcloud_to_laserscan)."""
