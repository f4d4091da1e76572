"""Names of rospy that need no node: names, checks of arguments, exceptions, times."""

import os
import pickle
import sys
import time
import warnings

warnings.simplefilter("ignore")
import rospy
import rospy.client
import rospy.core
import rospy.exceptions
import rospy.impl.paramserver
import rospy.impl.tcpros_base
import rospy.impl.tcpros_service
import rospy.logger_level_service_caller
import rospy.names
import rospy.rostime
import rospy.service
import rospy.topics
from rospy.impl.tcpros_service import convert_return_to_response
from std_msgs.msg import Header, String
from std_srvs.srv import Empty, EmptyResponse, SetBool, SetBoolResponse, Trigger, TriggerResponse


def t(title, call):
    try:
        value = call()
        print(title, type(value).__name__, repr(value))
    except Exception as error:
        text = str(error).partition("parameters:")[0]
        text = "" if "erialization" in type(error).__name__ or isinstance(error, KeyError) else text
        print(title, "raised", type(error).__name__, text)


# Constants
for module in (
    rospy.core,
    rospy.names,
    rospy.service,
    rospy.topics,
    rospy.impl.paramserver,
    rospy,
    rospy.client,
):
    for name in (
        "ANYTYPE",
        "BIDIRECTIONAL",
        "MASTER_NAME",
        "REMAP",
        "ROSRPC",
        "SEP",
        "TCPROS",
        "SERVICE_ANYTYPE",
        "TOPIC_ANYTYPE",
        "FATAL",
        "TIMEOUT_READY",
        "GLOBALNS",
        "PRIV_NAME",
    ):
        print(module.__name__, name, getattr(module, name, "not there"))

print(rospy.service.INBOUND, rospy.service.OUTBOUND)

# Names
CASES = [
    "",
    "/",
    "a",
    "/a",
    "~a",
    "~",
    "a/b",
    "/a/b/",
    "a//b",
    "//a",
    "a-b",
    "1a",
    "_a",
    "a.b",
    "a b",
    "/a/~b",
    "~a/b",
    "~/a",
    "a/",
    b"a",
]
validators = {
    "unresolved": rospy.names.valid_name_validator_unresolved,
    "resolved": rospy.names.valid_name_validator_resolved,
}
for case in CASES:
    for function in (
        rospy.names.canonicalize_name,
        rospy.names.resolve_name_without_node_name,
        rospy.names.isstring,
        rospy.names.is_global,
        rospy.names.is_private,
    ):
        if case != b"a":
            t(f"{function.__name__} {case!r}", lambda: function(case))
    for name, validator in validators.items():
        t(f"{name} {case!r}", lambda: validator("the_name", case, "/caller"))
    for resolve in (True, False):
        t(f"valid_name {case!r}", lambda: rospy.names.valid_name("the_name", resolve)(case, "/caller/x"))
    t(f"global_name {case!r}", lambda: rospy.names.global_name("the_name")(case, "/caller/x"))
    t(f"is_topic {case!r}", lambda: rospy.core.is_topic("the_topic")(case, "/caller/x"))
for value in (3, None, [], 1.5):
    for name, validator in validators.items():
        t(name, lambda: validator("the_name", value, "/caller"))
    t("isstring", lambda: rospy.impl.tcpros_service.isstring(value))
    t("is_topic", lambda: rospy.core.is_topic("p")(value, "/c"))
t("valid_name", lambda: callable(rospy.names.valid_name("p")))
for argv in ([], ["a:=b"], ["x", "a:=/b/c", "_p:=1", "__name:=n", "~q:=z", "c:=", ":=d", "a:=b:=c", "/g:=h"]):
    t("mappings", lambda: rospy.names.reload_mappings(argv))
    for node in ("/node", "/ns/node"):
        t("initialize", lambda: rospy.names.initialize_mappings(node))
        t(
            "mappings",
            lambda: (sorted(rospy.names.get_mappings().items()), sorted(rospy.names.get_resolved_mappings().items())),
        )
        for name in ("a", "/a", "~q", "b", "/g", "c"):
            t("resolve", lambda: rospy.names.resolve_name(name, node))
            t("without", lambda: rospy.names.resolve_name_without_node_name(name))
rospy.names.reload_mappings([])
rospy.names.initialize_mappings("/node")

# Exceptions
for name in (
    "ROSInternalException",
    "ROSSerializationException",
    "TransportException",
    "TransportTerminated",
    "TransportInitError",
    "ROSException",
    "ROSInitException",
    "ROSInterruptException",
    "ROSTimeMovedBackwardsException",
):
    kind = getattr(rospy.exceptions, name)
    print(name, [each.__name__ for each in kind.__mro__], getattr(rospy, name, None) is kind)
    for arguments in ((), ("text",), ("text", 2), (3,)):
        t(name, lambda: (str(kind(*arguments)), kind(*arguments).args))
t("time", lambda: rospy.exceptions.ROSTimeMovedBackwardsException(1.5).time)
t("console", lambda: str(rospy.logger_level_service_caller.ROSConsoleException("text")))
print([each.__name__ for each in rospy.logger_level_service_caller.ROSConsoleException.__mro__][:2])

# Times
for kind in (rospy.Time, rospy.Duration, rospy.rostime.Time, rospy.rostime.Duration):
    for arguments in ((), (1,), (1.5,), (-1,), (1, 2), (0, -1), (1, 1999999999), (1.5, 2), (2**33,)):
        t(f"{kind.__name__} {arguments}", lambda: kind(*arguments))
    one = kind(3, 1500000000) if kind else None
    print(one.to_sec(), one.to_nsec(), one.secs, one.nsecs, one.canon(), one, hash(one) == hash(kind(4, 500000000)))
    one.nsecs += 2000000000
    t("canon", lambda: (one.canon(), one))
    print(kind.from_sec(2.25), type(kind.from_sec(2.25)).__module__, pickle.loads(pickle.dumps(one)) == one)
t("to_time", lambda: rospy.Time(3, 5).to_time())
t("to_time", lambda: rospy.rostime.Time.from_sec(1.5).to_time())
t("negative", lambda: rospy.Duration(-1, -5).canon())
t("from_seconds", lambda: rospy.Time.from_seconds(3.5))
t("now", lambda: rospy.Time.now())
t("get_rostime", lambda: rospy.get_rostime())
t("get_time", lambda: rospy.get_time())
t("is_rostime_initialized", lambda: rospy.rostime.is_rostime_initialized())
t("is_wallclock", lambda: rospy.rostime.is_wallclock())
condition = rospy.rostime.get_rostime_cond()
print(hasattr(condition, "wait"), hasattr(condition, "notify_all"), condition is rospy.rostime.get_rostime_cond())
with condition:
    print(condition.wait(0.001))
t("set", lambda: rospy.rostime.set_rostime_initialized(True))
t("is_rostime_initialized", lambda: rospy.rostime.is_rostime_initialized())
t("get_rostime", lambda: abs(rospy.get_rostime().to_sec() - time.time()) < 60)
t("switch", lambda: rospy.rostime.switch_to_wallclock())
t("is_wallclock", lambda: rospy.rostime.is_wallclock())
t("now", lambda: abs(rospy.get_time() - time.time()) < 60)
t("set", lambda: rospy.rostime.set_rostime_initialized(False))
t("is_rostime_initialized", lambda: rospy.rostime.is_rostime_initialized())
t("get_rostime", lambda: abs(rospy.get_rostime().to_sec() - time.time()) < 60)
event = rospy.timer.TimerEvent(*"abcde")
print(event.last_expected, event.last_real, event.current_expected, event.current_real, event.last_duration)
t("few", lambda: rospy.timer.TimerEvent(1, 2))

# Private parameters of a command line
for argv in (
    [],
    ["_a:=1"],
    ["x", "_a:=1", "_b:='text'", "__name:=x", "a:=b", "_c:=[1, 2]", "_d:={x: 1}", "_e:="],
    ["_a:=[1"],
    ["_a:=1", "_a:=2"],
    ["~a:=1"],
    ["_a/b:=3"],
):
    t("load", lambda: sorted(rospy.client.load_command_line_node_params(argv).items()))

# What handlers of services return
for response in (
    SetBoolResponse(True, "a"),
    [True, "a"],
    (True, "a"),
    {"success": True},
    {"no": 1},
    {},
    [],
    [True],
    None,
    True,
    "a",
    [1, 2, 3],
    TriggerResponse(True, "a"),
    EmptyResponse(),
    3.5,
    {"success": True, "message": "m"},
):
    t("SetBool", lambda: convert_return_to_response(response, SetBoolResponse))
    t("Empty", lambda: convert_return_to_response(response, EmptyResponse))

# Headers as fields of numpy
import io

import numpy

buffer = io.BytesIO()
header = Header(3, rospy.Time(4, 5), "frame")
t("serialize_numpy", lambda: header.serialize_numpy(buffer, numpy))
print(buffer.getvalue())
t("deserialize_numpy", lambda: Header().deserialize_numpy(buffer.getvalue(), numpy))
t("short", lambda: Header().deserialize_numpy(b"\x00", numpy))
t("wrong", lambda: Header(seq="x").serialize_numpy(io.BytesIO(), numpy))
t("rospy.Header", lambda: rospy.Header(seq=1) == Header(1, None, None) if False else type(rospy.Header()).__name__)
print(rospy.Header is Header or rospy.Header._md5sum == Header._md5sum)

# Copies of parameters
cache = rospy.impl.paramserver.ParamServerCache()
calls = []
t("notifier", lambda: cache.set_notifier(lambda *arguments: calls.append(arguments)))
for key, value in (
    ("/a", 1),
    ("/b/c", 2),
    ("/d", {"x": {"y": 1}, "z": 2}),
    ("/a/", 3),
    ("e", 4),
    ("/p/q/r", 9),
    ("/d", 5),
):
    t(f"set {key}", lambda: cache.set(key, value))
    t(f"get {key}", lambda: cache.get(key))
for key in ("/a", "/b", "/b/c", "/d", "/d/x", "/", "/no", "", "/p", "/p/q", "e"):
    t(f"get {key}", lambda: cache.get(key))
for key, value in (("/a", 10), ("/no", 8), ("/b", 9), ("/p/q/r", 3), ("/d", {"only": 1}), ("/d/only", 2), ("/d", {})):
    t(f"update {key}", lambda: cache.update(key, value))
    t(f"get {key}", lambda: cache.get(key))
    print([name for name, _ in calls])
for key in ("/a", "/a", "/p/q/r", "/p", "/", "/no"):
    t(f"delete {key}", lambda: cache.delete(key))
    t(f"get {key}", lambda: cache.get(key))
t("notifier", lambda: cache.set_notifier(None))
t("set", lambda: (cache.set("/a", 1), cache.update("/a", 2), cache.get("/a")))
print(len(calls), type(rospy.impl.paramserver.get_param_server_cache()).__name__)

# Addresses
for uri in ("http://a:1", "", None, "a", "rosrpc://a:1", "http://", 3):
    t("xmlrpcapi", lambda: rospy.core.xmlrpcapi(uri) is None)
    t("parse", lambda: rospy.core.parse_rosrpc_uri(uri))
t("api", lambda: rospy.core.xmlrpcapi(os.environ["ROS_MASTER_URI"], cache=False).getPid("/x")[0])
handler = rospy.core.NullHandler()
print(handler.emit("anything"), handler.level)

# Bytes that are no text
import codecs

import genpy.message

handler = genpy.message.RosMsgUnicodeErrors()
print(handler.msg_type, type(codecs.lookup_error("rosmsg")).__name__, ascii(b"a\xffb\xc3".decode("utf-8", "rosmsg")))
for error in (
    UnicodeDecodeError("utf-8", b"a\xff", 1, 2, "why"),
    UnicodeEncodeError("ascii", "\xe9", 0, 1, "why"),
    ValueError("x"),
):
    t("replaced", lambda: ascii(handler(error)))
