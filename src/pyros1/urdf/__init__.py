"""Descriptions of robots (URDF), poses of their links, and the nodes that publish the states of their joints."""
