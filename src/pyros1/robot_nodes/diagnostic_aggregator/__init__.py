"""Publishes a robot's diagnostics as a tree (https://wiki.ros.org/diagnostic_aggregator)."""
