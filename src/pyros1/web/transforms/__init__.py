"""Processes the robot's data for views before it is sent to a page."""
