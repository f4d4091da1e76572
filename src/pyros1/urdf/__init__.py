"""Robot descriptions (URDF), and the nodes that publish a robot's joint states and the poses of its links."""
