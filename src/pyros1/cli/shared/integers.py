"""Ranges of integers."""

from __future__ import annotations

INT_RANGE = range(-(2**31), 2**31)
"""Integers that parameters can have: those of XML-RPC, with 32 bits."""

PORT_RANGE = range(65536)
"""Port numbers. 0 stands for the default port."""
