"""Stacks of rosbuild."""

from pyros1.drop_in.missing import missing

__getattr__ = missing(__name__)


class InvalidStack(Exception):
    """A stack.xml is wrong."""
