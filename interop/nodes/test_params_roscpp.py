"""Parameters shared by pyros1 and roscpp."""

from __future__ import annotations

from cases import Parameters


class TestRoscpp(Parameters):
    kind = "roscpp"
