"""smach, by pyros1: tasks as hierarchical state machines in Python (https://wiki.ros.org/smach)."""

from pyros1.drop_in.module_attributes import module_getattr
from smach.concurrence import Concurrence
from smach.container import Container
from smach.exceptions import (
    InvalidConstructionError,
    InvalidStateError,
    InvalidTransitionError,
    InvalidUserCodeError,
    SmachError,
)
from smach.iterator import Iterator
from smach.log import logdebug, logerr, loginfo, logwarn, set_loggers
from smach.sequence import Sequence
from smach.state import CBState, State
from smach.state_machine import StateMachine
from smach.user_data import Remapper, UserData
from smach.util import CBInterface, cb_interface, has_smach_interface, is_shutdown, set_shutdown_check

__getattr__ = module_getattr("smach")
