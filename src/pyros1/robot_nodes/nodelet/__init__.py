"""The package nodelet: where the class of a nodelet has a node here, that is run in a process of its own.

See https://wiki.ros.org/nodelet.
"""
