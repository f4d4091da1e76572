"""rviz's files of displays, read for the 3D panel."""
