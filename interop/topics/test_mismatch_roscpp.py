"""Types that do not match, between pyros1 and roscpp."""

from __future__ import annotations

from cases import Mismatch


class TestRoscpp(Mismatch):
    kind = "roscpp"
