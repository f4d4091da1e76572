"""actionlib, by pyros1: clients and servers of actions (https://wiki.ros.org/actionlib)."""

from actionlib.action_client import *  # noqa: F403
from actionlib.action_server import *  # noqa: F403
from actionlib.exceptions import ActionException
from actionlib.simple_action_client import *  # noqa: F403
from actionlib.simple_action_server import *  # noqa: F403
from pyros1.drop_in.module_attributes import module_getattr as _module_getattr

__getattr__ = _module_getattr("actionlib")
