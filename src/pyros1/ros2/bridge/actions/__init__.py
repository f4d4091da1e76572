"""Actions between ROS 1 and ROS 2, in both directions."""
