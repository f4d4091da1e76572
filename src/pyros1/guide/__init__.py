"""The guide: an introduction to ROS in steps, from a first package to a robot; how-to pages; and examples to copy."""
