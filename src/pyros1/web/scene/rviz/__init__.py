"""Converts rviz's display configuration files to settings of the 3D panel."""
