"""The base class of roslib's exceptions."""

from pyros1.drop_in.module_attributes import module_getattr

__getattr__ = module_getattr(__name__)


class ROSLibException(Exception):
    """An operation of roslib failed."""
