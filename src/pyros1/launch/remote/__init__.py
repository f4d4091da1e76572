"""Starts nodes on other machines; contains both ends of the connection to a machine."""
