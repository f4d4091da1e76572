"""Starts nodes on other machines: both ends of the connection."""
