"""Times of messages (https://wiki.ros.org/msg#Fields)."""

from pyros1.drop_in.missing import missing
from pyros1.ground.timing import Duration, Time, TVal

__all__ = ["Duration", "TVal", "Time"]

__getattr__ = missing(__name__)

for _class in (TVal, Time, Duration):
    _class.__module__ = __name__  # programs for stock expect genpy's name, for example in pickles and texts of values
