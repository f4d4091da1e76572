"""Messages of many types between pyros1 and rospy."""

from __future__ import annotations

from cases import Types


class TestRospy(Types):
    kind = "rospy"
