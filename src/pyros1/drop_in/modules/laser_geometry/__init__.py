"""laser_geometry, by pyros1: laser scans as point clouds (https://wiki.ros.org/laser_geometry)."""

from laser_geometry.laser_geometry import LaserProjection
