"""Times; this module is older than genpy."""

from genpy.rostime import Duration, Time, TVal

from pyros1.drop_in.module_attributes import module_getattr

__getattr__ = module_getattr(__name__)
