"""Parameters shared by pyros1 and rospy."""

from __future__ import annotations

from cases import Parameters


class TestRospy(Parameters):
    kind = "rospy"
