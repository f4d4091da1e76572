"""The network of rmw_zenoh, with which ROS 2 programs find each other and exchange messages over zenoh."""
