"""Prepares the robot's data for views: log messages, curves, frames, rates."""
