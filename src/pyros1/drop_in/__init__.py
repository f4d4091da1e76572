"""Modules named like stock ROS 1's, so that Python programs written for stock run unmodified.

`finder.Finder` finds them. `start/sitecustomize.py` installs it in programs that pyros1 starts, and ``pyros1 rospy
enable`` in all programs of a virtual environment. Each module is a thin wrapper around pyros1. They share the default
node of the process (`process`), the only module-level state in pyros1.
"""
