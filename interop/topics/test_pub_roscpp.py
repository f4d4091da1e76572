"""A pyros1 publisher and a roscpp subscriber.

Feature: our publishers reach roscpp subscribers
"""

from __future__ import annotations

from cases import Publishing


class TestRoscpp(Publishing):
    kind = "roscpp"
