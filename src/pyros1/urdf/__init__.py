"""Descriptions of robots (URDF), where their links are, and the nodes that publish the states of their joints."""
