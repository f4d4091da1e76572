"""Latched topics between pyros1 and rospy.

Feature: latched topics
"""

from __future__ import annotations

from cases import Latching


class TestRospy(Latching):
    kind = "rospy"
