"""Modules under the names of stock ROS 1, so that its Python programs run unmodified.

They are found by `finder.Finder`, which `start/sitecustomize.py` installs in programs that pyros1 starts, and
``pyros1 rospy enable`` in all programs of a virtual environment. Each module is a thin wrapper around pyros1.
They share the default node of the process (`process`), the only state at module level in pyros1.
"""
