"""What integers a parameter can hold."""

from __future__ import annotations

INT_RANGE = range(-(2**31), 2**31)
"""XML-RPC's, with 32 bits."""
