"""A pyros1 subscriber and a roscpp publisher."""

from __future__ import annotations

from cases import Subscribing


class TestRoscpp(Subscribing):
    kind = "roscpp"
