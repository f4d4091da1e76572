"""The types ``time`` and ``duration`` of message fields (https://wiki.ros.org/msg#Fields)."""

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.ground.timing import Duration, Time, TVal

__all__ = ["Duration", "TVal", "Time"]

__getattr__ = module_getattr(__name__)

for _class in (TVal, Time, Duration):
    _class.__module__ = __name__  # programs written for stock expect genpy's name, for example in pickles
