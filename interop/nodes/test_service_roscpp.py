"""A pyros1 service and a roscpp client."""

from __future__ import annotations

from cases import Serving


class TestRoscpp(Serving):
    kind = "roscpp"
