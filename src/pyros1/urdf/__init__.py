"""Reads robot descriptions (URDF), and provides the nodes that publish a robot's joint states and its links' poses."""
