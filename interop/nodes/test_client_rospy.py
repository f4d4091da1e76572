"""A pyros1 client and a rospy service."""

from __future__ import annotations

from cases import Calling


class TestRospy(Calling):
    kind = "rospy"
