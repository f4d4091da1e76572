"""A pyros1 subscriber and a roscpp publisher.

Feature: roscpp publishers reach our subscribers -- all field kinds, large images
"""

from __future__ import annotations

from cases import Subscribing


class TestRoscpp(Subscribing):
    kind = "roscpp"
