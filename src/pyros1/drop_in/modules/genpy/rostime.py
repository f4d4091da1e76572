"""Times of messages."""

from pyros1.ground.timing import Duration, Time, TVal

__all__ = ["Duration", "TVal", "Time"]
