"""The package rosout: a node that collects the log messages of all nodes (https://wiki.ros.org/rosout)."""
