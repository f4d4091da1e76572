"""Latched topics between pyros1 and roscpp."""

from __future__ import annotations

from cases import Latching


class TestRoscpp(Latching):
    kind = "roscpp"
