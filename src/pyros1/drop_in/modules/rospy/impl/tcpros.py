"""Connections by TCPROS (https://wiki.ros.org/ROS/TCPROS)."""

from pyros1.drop_in.module_attributes import module_getattr
from rospy.impl.tcpros_base import DEFAULT_BUFF_SIZE

__all__ = ["DEFAULT_BUFF_SIZE"]

_OWN = "pyros1's nodes accept connections themselves; see Publisher.impl and rospy.impl.tcpros_base"
__getattr__ = module_getattr("rospy.impl.tcpros", get_tcpros_handler=_OWN, init_tcpros=_OWN)
