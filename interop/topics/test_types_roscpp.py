"""Messages of many types between pyros1 and roscpp."""

from __future__ import annotations

from cases import Types


class TestRoscpp(Types):
    kind = "roscpp"
