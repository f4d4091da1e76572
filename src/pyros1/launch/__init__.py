"""Reads launch files into plans, and runs plans as supervised processes (https://wiki.ros.org/roslaunch)."""
