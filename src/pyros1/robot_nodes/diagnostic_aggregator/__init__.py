"""The diagnostics of a robot as a tree (https://wiki.ros.org/diagnostic_aggregator)."""
