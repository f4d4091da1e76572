"""Log messages between pyros1 and roscpp."""

from __future__ import annotations

from cases import Logging


class TestRoscpp(Logging):
    kind = "roscpp"
