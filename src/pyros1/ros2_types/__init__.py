"""ROS 2 types: their fields, hashes and encoding, and their ROS 1 counterparts."""
