"""Messages that were in roslib before they moved to std_msgs and rosgraph_msgs."""

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.msgs.rosgraph_msgs.msg import Clock, Log
from pyros1.msgs.std_msgs.msg import Header

__all__ = ["Clock", "Header", "Log"]

__getattr__ = module_getattr(__name__)
