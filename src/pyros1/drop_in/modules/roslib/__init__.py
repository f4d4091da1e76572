"""roslib, by pyros1 (https://wiki.ros.org/roslib)."""

from roslib.launcher import load_manifest

__all__ = ["load_manifest"]
