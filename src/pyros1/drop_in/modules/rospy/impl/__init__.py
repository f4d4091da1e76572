"""The parts of rospy.impl that programs use."""

from pyros1.drop_in.missing import names as _names

_reason = "pyros1's nodes do this themselves"
__getattr__, __dir__ = _names(__name__, why={"udpros": _reason, "masterslave": _reason})
