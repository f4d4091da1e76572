"""rospy, by pyros1: the names and behaviour of ROS 1's client library for Python (https://wiki.ros.org/rospy)."""

from pyros1.msgs.std_msgs.msg import Header
from rospy.client import (
    DEBUG,
    ERROR,
    FATAL,
    INFO,
    WARN,
    delete_param,
    get_master,
    get_param,
    get_param_cached,
    get_param_names,
    get_published_topics,
    has_param,
    init_node,
    myargv,
    on_shutdown,
    search_param,
    set_param,
    spin,
    wait_for_message,
)
from rospy.core import (
    get_node_uri,
    get_ros_root,
    is_shutdown,
    logdebug,
    logdebug_once,
    logdebug_throttle,
    logerr,
    logerr_once,
    logerr_throttle,
    logfatal,
    logfatal_once,
    logfatal_throttle,
    loginfo,
    loginfo_once,
    loginfo_throttle,
    logout,
    logwarn,
    logwarn_once,
    logwarn_throttle,
    parse_rosrpc_uri,
    signal_shutdown,
)
from rospy.exceptions import (
    ROSException,
    ROSInitException,
    ROSInternalException,
    ROSInterruptException,
    ROSSerializationException,
    ROSTimeMovedBackwardsException,
    TransportException,
    TransportInitError,
    TransportTerminated,
)
from rospy.msg import AnyMsg, Message
from rospy.msproxy import MasterProxy
from rospy.names import get_caller_id, get_name, get_namespace, remap_name, resolve_name
from rospy.rostime import Duration, Time, get_rostime, get_time
from rospy.service import Service, ServiceException, ServiceProxy, wait_for_service
from rospy.timer import Rate, Timer, sleep
from rospy.topics import Publisher, SubscribeListener, Subscriber
