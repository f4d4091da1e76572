"""Names and arguments in forms that programs seldom use, with a node: private places, numpy's numbers, names like ~/x,
lists for dictionaries, None for messages, modules whose names come with a star."""

import decimal
import logging
import sys
import threading
import time
import types
import warnings

warnings.simplefilter("ignore")
import actionlib.action_client
import actionlib.exceptions
import actionlib.simple_action_server
import actionlib.msg
import diagnostic_updater
import dynamic_reconfigure.server
import genmsg
import genpy.dynamic
import numpy
import rosbag.rosbag_main
import rosgraph.masterapi
import rosmsg
import rospy
import rospy.client
import rospy.core
import rospy.impl.tcpros_service
import rospy.msg
import rospy.msproxy
import rospy.timer
import tf
import tf.broadcaster
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import JointState
from std_msgs.msg import Header, String
from std_srvs.srv import Empty
from tf2_msgs.msg import TFMessage


def t(title, call):
    try:
        print(title, repr(call()), flush=True)
    except Exception as error:
        print(
            title,
            "raised",
            [each.__name__ for each in type(error).__mro__ if each.__module__[:2] in ("ro", "ge", "bu")][:1],
        )


def until(reached):
    end = time.monotonic() + 15
    while not reached():
        assert time.monotonic() < end, "not in time"
        time.sleep(0.005)


rospy.init_node("forms")
rosout = logging.getLogger("rosout")
rosout.setLevel(logging.DEBUG)
lines = []


class Keep(logging.Handler):
    def emit(self, record):
        lines.append((record.levelname, record.getMessage()))


for handler in rosout.handlers[:]:
    rosout.removeHandler(handler)
rosout.addHandler(Keep())

# Logs by the module that has them
for number in range(2):
    rospy.core.logdebug_once("d")
    rospy.core.loginfo_once("i %d", number)
    rospy.core.logwarn_once("w")
    rospy.core.logerr_once("e")
    rospy.core.logfatal_once("f")
    rospy.core.logdebug_throttle(100, "d")
    rospy.core.loginfo_throttle(100, "i %s" % number)
    rospy.core.logwarn_throttle(100, "w")
    rospy.core.logerr_throttle(100, "e")
    rospy.core.logfatal_throttle(100, "f")
    rospy.core.logdebug_throttle_identical(100, "d %d" % number)
    rospy.core.loginfo_throttle_identical(100, "i")
    rospy.core.logwarn_throttle_identical(100, "w")
    rospy.core.logerr_throttle_identical(100, "e")
    rospy.core.logfatal_throttle_identical(100, "f")
    rospy.logdebug_once("of rospy")
    rospy.logwarn_once("of rospy")
    rospy.logfatal_once("of rospy")
    rospy.logdebug_throttle(100, "of rospy")
    rospy.logerr_throttle(100, "of rospy")
    rospy.logfatal_throttle(100, "of rospy")
rospy.core.logdebug("d %s", 1)
rospy.core.logwarn("w")
rospy.core.logerr("e")
rospy.core.logfatal("f")
print(*lines, sep="\n")
rosout.setLevel(logging.CRITICAL)

# Names
rospy.set_param("~x", "private")
rospy.set_param("/x", "global")
for name in ("~/x", "~x", "~//x", "x", "/x"):
    t(name, lambda: (rospy.get_param(name), rospy.has_param(name), rospy.resolve_name(name)))
    t(name, lambda: rospy.Publisher(name, String, queue_size=1).resolved_name)
    t(name, lambda: rospy.Subscriber(name, String).resolved_name)
    t(name, lambda: rospy.Service(f"{name}_of_service", Empty, None).resolved_name)
    t(name, lambda: rospy.ServiceProxy(name, Empty).resolved_name)
    t(name, lambda: rospy.get_param_cached(name))
t("root", lambda: (rospy.resolve_name("~"), rospy.get_param("~")["x"], rospy.resolve_name("~", "/other")))
t("set", lambda: (rospy.set_param("~/y", 1), rospy.get_param("/y"), rospy.delete_param("~/y"), rospy.has_param("/y")))
print(sorted(name for name, _ in rospy.get_published_topics() if name[-1] == "x"))

# Numbers
for seconds in (
    numpy.float32(1.5),
    numpy.float64(1.5),
    numpy.int16(2),
    numpy.uint8(3),
    decimal.Decimal("1.25"),
    True,
    numpy.float16(0.25),
):
    for kind in (rospy.Duration, rospy.Time):
        t(type(seconds).__name__, lambda: (kind(seconds), kind.from_sec(float(seconds))))
    t("both", lambda: rospy.Duration(seconds, 5))
    t("times", lambda: rospy.Duration(2) * seconds)
start = time.monotonic()
rospy.timer.sleep(rospy.Duration(numpy.float32(0.02)))
print(time.monotonic() - start >= 0.02)

# Messages: any, short states, definitions
got = []
subscriber = rospy.Subscriber("words", rospy.msg.AnyMsg, got.append)
publisher = rospy.Publisher("words", String, queue_size=3, latch=True, headers=[("more", "text")])
until(lambda: publisher.get_num_connections() and subscriber.get_num_connections())
publisher.publish("hello")
until(lambda: got)
print(got[0].__slots__, got[0]._buff, got[0]._connection_header["more"], String.__slots__)
one = rospy.msg.AnyMsg()
print(one.deserialize(b"abc") is one, one._buff)
import io

buffer = io.BytesIO()
one.serialize(buffer)
print(buffer.getvalue())
t("wait", lambda: rospy.client.wait_for_message("/words", rospy.AnyMsg, 5)._buff)
state = JointState()
state.__setstate__([Header(frame_id="f"), ["a"]])
print(state.header.frame_id, state.name)
for text in ("int32", "int32 x y", "int32[a] x", "int32 1x", "int32 X=", "===\nMSG: a/C\nint32 x"):
    try:
        print(sorted(genpy.dynamic.generate_dynamic("a/B", text)))
    except genmsg.InvalidMsgSpec:
        print(text, "is wrong")

# Timers
rate = rospy.timer.Rate(1000)
rate.sleep()
print(type(rate.remaining()).__name__)
events = []
timer = rospy.timer.Timer(rospy.Duration(0.01), events.append)
until(lambda: len(events) > 1)
timer.shutdown()
timer.join(5)
print(timer.is_alive(), callable(rospy.timer.Timer.run), events[0].last_real, events[1].last_duration >= 0)

# Services that go wrong
seen = []
service = rospy.impl.tcpros_service.Service(
    "wrong", Empty, lambda request: 1 / 0, error_handler=lambda error, *rest: seen.append((error, len(rest)))
)
t("call", lambda: rospy.ServiceProxy("wrong", Empty)())
print(seen, callable(service.error_handler))

# The master
proxy = rospy.msproxy.MasterProxy(rospy.get_master().getUri()[2])
print(proxy.search_param("x"), proxy.get_param_cached("x"))
t("none", lambda: proxy.get_param_cached("none"))
master = rosgraph.masterapi.Master("/me")
for value in (None, 2**40, {1: 2}, rospy.Duration(1), {"a": [1, None]}):
    try:
        master.setParam("/odd", value)
    except (TypeError, OverflowError) as error:
        print(type(error).__name__)
print([genpy.message.get_message_class(name) for name in ("time", "duration")])
print(master.getUri() == rospy.get_master().getUri()[2], ["/words", "std_msgs/String"] in master.getTopicTypes())
for kind, call in (
    (rosgraph.masterapi.Error, lambda: master.lookupNode("/nobody")),
    (rosgraph.masterapi.MasterException, lambda: master.lookupService("/nothing")),
    (rosgraph.masterapi.ROSMasterException, lambda: master.getParam("/none")),
):
    try:
        call()
    except kind as error:
        print(type(error).__name__, isinstance(error, rosgraph.masterapi.Failure))

# Frames
frames = []
rospy.Subscriber("/tf", TFMessage, frames.append)
broadcaster = tf.broadcaster.TransformBroadcaster()
stamped = TransformStamped(child_frame_id="c")


def heard():
    broadcaster.sendTransform((1, 2, 3), (0, 0, 0, 1), rospy.Time(5), "b", "a")
    broadcaster.sendTransformMessage(stamped)
    return len({each.transforms[0].child_frame_id for each in frames}) == 2


until(heard)
for kind in (tf.listener.Transformer, tf.listener.TransformerROS, tf.TransformListener):
    print(kind().setUsingDedicatedThread(True))

# Actions
server = actionlib.simple_action_server.SimpleActionServer("act", actionlib.msg.TestAction, auto_start=False)
stopped = []
server.register_preempt_callback(lambda: stopped.append(1))
server.start()
client = actionlib.SimpleActionClient("act", actionlib.msg.TestAction)
print(client.wait_for_server(rospy.Duration(15)))
client.send_goal(actionlib.msg.TestGoal(4))
until(server.is_new_goal_available)
print(server.accept_new_goal().goal)
t("feedback", lambda: server.publish_feedback(None))
t("feedback", lambda: server.publish_feedback(actionlib.msg.TestFeedback(3)))
server.internal_preempt_callback(server.current_goal)
print(server.is_preempt_requested(), stopped)
server.set_aborted(None, "stopped")
until(lambda: client.get_state() == actionlib.action_client.TerminalState.ABORTED)
t("none", lambda: client.send_goal(None))
names = actionlib.action_client.TerminalState
print(
    names.RECALLED,
    names.REJECTED,
    names.to_string(names.ABORTED),
    issubclass(actionlib.exceptions.ActionException, Exception),
)
print(actionlib.TerminalState.ABORTED, actionlib.TerminalState.RECALLED, actionlib.TerminalState.REJECTED)

# A server of parameters: the order of its values, and its service
config = types.ModuleType("Config")
parameters = [
    {
        "name": name,
        "type": kind,
        "default": default,
        "min": low,
        "max": high,
        "level": 1,
        "description": "",
        "edit_method": "",
    }
    for name, kind, default, low, high in (
        ("d", "double", 0.5, 0.0, 1.0),
        ("i", "int", 5, 0, 10),
        ("s", "str", "x", "", ""),
        ("b", "bool", True, False, True),
    )
]
config.config_description = {
    **{"name": "Default", "type": "", "state": True, "cstate": "true", "id": 0, "parent": 0, "parentname": ""},
    **{"class": "C", "parentclass": "", "parameters": parameters, "groups": [], "upper": "", "lower": "", "field": ""},
}
for field, key in (("defaults", "default"), ("min", "min"), ("max", "max"), ("level", "level"), ("type", "type")):
    setattr(config, field, {each["name"]: each[key] for each in parameters})
for _ in range(2):  # the second takes the place of the first
    server = dynamic_reconfigure.server.Server(config, lambda values, level: values, "some")
    print(list(server.config), server.update_configuration({"i": 30})["i"])
    print(server.set_service.resolved_name, server.set_service.service_class.__name__, server.set_service.uri[:10])
    print(server.set_service.request_class.__name__, server.set_service.response_class.__name__)
    server.set_service.shutdown("enough")

# Diagnostics, tools
diagnosed = diagnostic_updater.DiagnosedPublisher(
    publisher,
    diagnostic_updater.Updater(),
    diagnostic_updater.FrequencyStatusParam({"min": 1, "max": 2}),
    diagnostic_updater.TimeStampStatusParam(),
)
t("publish", lambda: diagnosed.publish(String("no header")))
print(diagnosed.publisher is publisher)
for command in (rosmsg.rosmsg_cmd_list, rosmsg.rosmsg_cmd_packages):
    try:
        command(rosmsg.MODE_MSG, "message", ["x", "y", "--nothing"]) if command is rosmsg.rosmsg_cmd_list else command(
            rosmsg.MODE_MSG, "message", ["packages", "--nothing"]
        )
    except SystemExit as error:
        print(command.__name__, error.code)
try:
    rosbag.rosbag_main.record_cmd([])
except SystemExit as error:
    print("record", error.code)

# What a star brings along
for module in """actionlib tf tf.transformations diagnostic_updater dynamic_reconfigure.parameter_generator
        dynamic_reconfigure.parameter_generator_catkin""".split():
    found = {}
    exec(f"from {module} import *", found)
    print(
        module,
        [name for name in ("rospy", "sys", "os", "re", "math", "numpy", "threading", "inspect") if name in found],
    )
for module in (
    "tf2_ros",
    "tf2_geometry_msgs",
    "tf2_sensor_msgs",
    "dynamic_reconfigure.client",
    "dynamic_reconfigure.server",
):
    found = {}
    exec(f"from {module} import *", found)
    print(module, "rospy" in found)

rospy.delete_param("/x")
rospy.delete_param("~x")
threading.Timer(0.05, lambda: rospy.signal_shutdown("the end")).start()
rospy.client.spin()
print(rospy.is_shutdown())
sys.stdout.flush()
