"""Nodes on other machines, at both ends."""
