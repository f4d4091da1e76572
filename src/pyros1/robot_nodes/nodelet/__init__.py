"""The package nodelet: runs the node that replaces a nodelet, in its own process.

See https://wiki.ros.org/nodelet.
"""
