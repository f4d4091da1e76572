"""Messages that were in roslib before they moved to std_msgs and rosgraph_msgs."""

from pyros1.drop_in.missing import missing
from pyros1.msgs.rosgraph_msgs.msg import Clock, Log
from pyros1.msgs.std_msgs.msg import Header

__all__ = ["Clock", "Header", "Log"]

__getattr__ = missing(__name__)
