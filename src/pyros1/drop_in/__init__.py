"""Modules with the names of stock ROS 1's modules, so that Python programs for stock run unmodified.

They are found by `finder.Finder`, which is installed by `start/sitecustomize.py` in programs that pyros1 starts, and by
``pyros1 rospy enable`` in all programs of a virtual environment. Each module is a thin wrapper around pyros1. They
share the default node of the process (`process`), the only module-level state in pyros1.
"""
