"""rviz's display configuration files, read for the 3D panel."""
