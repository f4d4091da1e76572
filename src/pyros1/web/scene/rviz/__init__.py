"""Reads rviz's display configuration files for the 3D panel."""
