"""Parameters of ROS 2 nodes: for dynamic_reconfigure's tools, and for `pyros1 bridge param ros2:`."""
