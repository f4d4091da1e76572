"""A pyros1 service and a roscpp client.

Feature: roscpp and rospy call our services -- errors reach the caller
"""

from __future__ import annotations

from cases import Serving


class TestRoscpp(Serving):
    kind = "roscpp"
