"""The package nodelet: runs the node that replaces a nodelet's class, in its own process.

See https://wiki.ros.org/nodelet.
"""
