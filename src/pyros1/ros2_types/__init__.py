"""Types of ROS 2: their fields, hashes and encoding, and which types of ROS 1 they are."""
