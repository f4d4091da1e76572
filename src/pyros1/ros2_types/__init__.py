"""ROS 2 types: their fields, hashes and encoding, and which ROS 1 types they are."""
