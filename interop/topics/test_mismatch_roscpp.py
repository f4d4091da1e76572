"""Types that do not match, between pyros1 and roscpp.

Feature: both sides reject mismatched types and log the reason
"""

from __future__ import annotations

from cases import Mismatch


class TestRoscpp(Mismatch):
    kind = "roscpp"
