"""Talks to ROS 2 without an installation of it: its types, its encoding, and its network over zenoh."""
