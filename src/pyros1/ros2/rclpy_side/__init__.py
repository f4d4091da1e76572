"""ROS 2 through rclpy, if it is installed, with any middleware. Only `rclpy_modules` imports rclpy."""
