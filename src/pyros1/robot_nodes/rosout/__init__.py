"""The package rosout: the node that collects the log messages of all nodes (https://wiki.ros.org/rosout)."""
