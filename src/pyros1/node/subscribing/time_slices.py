"""Limits, in seconds and messages, of the turns that the sources of a subscription take; see `delivery`."""

from __future__ import annotations

MAX_FLOW_GAP = 0.02
"""Messages less than this many seconds apart flow: a separate thread then delivers them sooner."""
MAX_CALLBACK_TIME = 0.001
DRAIN_TIME = 0.02
"""Maximum seconds spent on draining sockets before callbacks continue: a flood must not starve them."""
MAX_TURN_TIME = 0.002
"""Seconds of callbacks after which it is another source's turn."""
MAX_BATCH = 128
BATCH_GROWTH_TIME = MAX_TURN_TIME / 8
"""Maximum number of messages between two clock readings; up to BATCH_GROWTH_TIME in a turn it doubles after each."""
