"""Large images between pyros1 and rospy."""

from __future__ import annotations

from cases import Large


class TestRospy(Large):
    kind = "rospy"
