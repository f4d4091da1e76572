"""A pyros1 subscriber and a rospy publisher.

Feature: rospy publishers reach our subscribers
"""

from __future__ import annotations

from cases import Subscribing


class TestRospy(Subscribing):
    kind = "rospy"
