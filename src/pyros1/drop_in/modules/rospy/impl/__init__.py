"""The parts of rospy.impl that programs use."""

from pyros1.drop_in.module_attributes import module_hooks as _module_hooks

_reason = "pyros1's nodes do this themselves"
__getattr__, __dir__ = _module_hooks(__name__, missing_reasons={"udpros": _reason, "masterslave": _reason})
