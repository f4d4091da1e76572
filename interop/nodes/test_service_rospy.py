"""A pyros1 service and a rospy client."""

from __future__ import annotations

from cases import Serving


class TestRospy(Serving):
    kind = "rospy"
