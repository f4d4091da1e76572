"""How the sources of a subscription take turns, in seconds and messages; see `delivery`."""

from __future__ import annotations

FLOWING = 0.02
"""Messages that come faster than every so many seconds flow: a thread of their own delivers them sooner."""
FRESH = 0.001
DRAIN_TIME = 0.02
"""Longest time, in seconds, spent on draining sockets before callbacks go on: a flood must not starve them."""
TURN = 0.002
"""Seconds of callbacks after which it is another source's turn."""
STRIDE = 128
EARLY = TURN / 8
"""Messages at most between two looks at the clock; until EARLY in a turn their number doubles after each look."""
