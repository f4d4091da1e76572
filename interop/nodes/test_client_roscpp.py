"""A pyros1 client and a roscpp service."""

from __future__ import annotations

from cases import Calling


class TestRoscpp(Calling):
    kind = "roscpp"
