"""turtlesim's programs: turtles that move and draw, for learning ROS (https://wiki.ros.org/turtlesim)."""
