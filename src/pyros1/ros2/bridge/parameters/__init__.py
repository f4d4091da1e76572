"""Parameters of ROS 2 nodes: for tools of dynamic_reconfigure, and for `pyros1 bridge param ros2:`."""
