"""A pyros1 publisher and a rospy subscriber.

Feature: our publishers reach rospy subscribers
"""

from __future__ import annotations

from cases import Publishing


class TestRospy(Publishing):
    kind = "rospy"
