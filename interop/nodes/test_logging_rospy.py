"""Log messages between pyros1 and rospy."""

from __future__ import annotations

from cases import Logging


class TestRospy(Logging):
    kind = "rospy"
