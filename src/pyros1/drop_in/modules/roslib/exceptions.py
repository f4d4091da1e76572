"""The base class of roslib's exceptions."""

from pyros1.drop_in.missing import missing

__getattr__ = missing(__name__)


class ROSLibException(Exception):
    """An operation of roslib failed."""
