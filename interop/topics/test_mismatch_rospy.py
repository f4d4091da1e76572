"""Types that do not match, between pyros1 and rospy."""

from __future__ import annotations

from cases import Mismatch


class TestRospy(Mismatch):
    kind = "rospy"
