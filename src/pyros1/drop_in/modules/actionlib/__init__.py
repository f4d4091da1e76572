"""actionlib, by pyros1: clients and servers of actions (https://wiki.ros.org/actionlib)."""

from actionlib.action_client import *  # noqa: F403
from actionlib.action_server import *  # noqa: F403
from actionlib.exceptions import ActionException
from actionlib.simple_action_client import *  # noqa: F403
from actionlib.simple_action_server import *  # noqa: F403
from pyros1.drop_in.missing import missing as _missing

__getattr__ = _missing("actionlib")
