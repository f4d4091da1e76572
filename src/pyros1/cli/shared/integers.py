"""Ranges of integers that are valid as arguments."""

from __future__ import annotations

INT_RANGE = range(-(2**31), 2**31)
"""The integers that parameters can hold: signed 32-bit integers, as in XML-RPC."""

PORT_RANGE = range(65536)
"""Port numbers. 0 represents the default port."""
