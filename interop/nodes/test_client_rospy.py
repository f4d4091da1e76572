"""A pyros1 client and a rospy service.

Feature: our clients call roscpp and rospy services -- also persistent
"""

from __future__ import annotations

from cases import Calling


class TestRospy(Calling):
    kind = "rospy"
