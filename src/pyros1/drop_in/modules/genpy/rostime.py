"""Times of messages."""

from pyros1.timing import Duration, Time, TVal

__all__ = ["Duration", "TVal", "Time"]
