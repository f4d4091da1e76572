"""Filters for laser scans (https://wiki.ros.org/laser_filters)."""
