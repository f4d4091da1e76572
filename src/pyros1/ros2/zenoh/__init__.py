"""rmw_zenoh's protocol, with which ROS 2 programs find each other and exchange messages over zenoh."""
