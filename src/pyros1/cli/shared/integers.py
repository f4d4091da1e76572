"""Ranges of integers."""

from __future__ import annotations

INT_RANGE = range(-(2**31), 2**31)
"""The integers that parameters can have as values: those with 32 bits, as in XML-RPC."""

PORT_RANGE = range(65536)
"""Port numbers. 0 represents the default port."""
