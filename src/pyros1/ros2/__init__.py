"""The connection to ROS 2: over zenoh, without an installation of ROS 2, or through rclpy."""
