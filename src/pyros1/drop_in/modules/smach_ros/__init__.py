"""smach_ros, by pyros1: state machines that use topics, services and actions (https://wiki.ros.org/smach_ros)."""

import rospy
import smach

from pyros1.drop_in.module_attributes import module_getattr
from smach_ros.action_server_wrapper import ActionServerWrapper
from smach_ros.condition_state import ConditionState
from smach_ros.introspection import IntrospectionClient, IntrospectionServer
from smach_ros.monitor_state import MonitorState
from smach_ros.service_state import ServiceState
from smach_ros.simple_action_state import SimpleActionState
from smach_ros.util import set_preempt_handler

smach.set_loggers(rospy.loginfo, rospy.logwarn, rospy.logdebug, rospy.logerr)
smach.set_shutdown_check(rospy.is_shutdown)

__getattr__ = module_getattr("smach_ros", RosState="it belongs to ROS 2", SmachNode="it belongs to ROS 2")
