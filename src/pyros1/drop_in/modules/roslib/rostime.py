"""Times; this module is older than genpy."""

from genpy.rostime import Duration, Time, TVal

from pyros1.drop_in.missing import missing

__getattr__ = missing(__name__)
