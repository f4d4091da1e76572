"""The clock of a bridge."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from functools import partial


def choose_clock() -> Callable[[], float]:
    """Return a monotonic clock function that also advances while the machine is suspended, so that messages that waited
    meanwhile count as old.
    """
    if sys.platform == "linux":
        return partial(time.clock_gettime, time.CLOCK_BOOTTIME)
    if sys.platform == "darwin":  # there, time.monotonic() stands still while the machine sleeps
        return partial(time.clock_gettime, time.CLOCK_MONOTONIC_RAW)
    return time.monotonic


steady_now = choose_clock()
