"""Large images between pyros1 and roscpp."""

from __future__ import annotations

from cases import Large


class TestRoscpp(Large):
    kind = "roscpp"
