"""Robot descriptions (URDF), the poses of links, and the nodes that publish joint states and poses."""
