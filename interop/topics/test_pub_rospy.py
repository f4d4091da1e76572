"""A pyros1 publisher and a rospy subscriber."""

from __future__ import annotations

from cases import Publishing


class TestRospy(Publishing):
    kind = "rospy"
