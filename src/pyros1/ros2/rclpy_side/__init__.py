"""ROS 2 through rclpy, where that is installed: with whatever middleware it uses. Only `rclpy_modules` imports it."""
