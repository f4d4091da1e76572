"""Limits, in seconds and messages, of the turns that the sources of a subscription take; see `delivery`."""

from __future__ import annotations

FLOWING = 0.02
"""Messages less than this many seconds apart flow: a separate thread then delivers them sooner."""
FRESH = 0.001
DRAIN_TIME = 0.02
"""Longest time, in seconds, spent on draining sockets before callbacks go on: a flood must not starve them."""
TURN = 0.002
"""Seconds of callbacks after which it is another source's turn."""
STRIDE = 128
EARLY = TURN / 8
"""Most messages between two readings of the clock; until EARLY in a turn their number doubles after each reading."""
