"""Parameters of nodes of ROS 2: for tools of dynamic_reconfigure, and for `pyros1 bridge param ros2:`."""
