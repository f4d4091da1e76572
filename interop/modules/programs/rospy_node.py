"""Names of rospy of a running node: log functions, topics and services in its lists, signals."""

import logging
import re
import signal
import socket
import sys
import threading
import warnings

warnings.simplefilter("ignore")
import rospy
import rospy.core
import rospy.names
import rospy.service
import rospy.topics
from rospy.impl.registration import get_service_manager, get_topic_manager
from rospy.topics import Topic
from std_msgs.msg import Header, String
from std_srvs.srv import Empty, Trigger


def clean(value):
    return re.sub(r"\b\d{4,5}\b|socket \w+", "NUMBER", re.sub(r" at 0x\w+", "", str(value)))


def t(title, call):
    try:
        value = call()
        print(title, type(value).__name__, clean(repr(value)))
    except Exception as error:
        print(title, "raised", [each.__name__ for each in type(error).__mro__[:2]], clean(error))


# Topics before there is a node
for arguments in (
    ("a", String, "pub"),
    ("", String, "pub"),
    (3, String, "pub"),
    (None, String, "sub"),
    ("a", None, "sub"),
    ("a", 3, "sub"),
    ("a", str, "sub"),
    ("a", Empty, "sub"),
    ("~a", String, "pub"),
    ("a", "String", "pub"),
):
    t("early", lambda: Topic(*arguments).resolved_name)
t("no kind", lambda: Topic("a", String, "x").name)

rospy.init_node("node_parts", log_level=rospy.INFO)
for arguments in (
    ("a", String, "pub"),
    ("a", String, "sub"),
    ("~a", Header, rospy.core.Registration.PUB if hasattr(rospy.core, "Registration") else "pub"),
    ("/x/y", String, "sub"),
    ("a b", String, "pub"),
    ("", String, "pub"),
):

    def show():
        topic = Topic(*arguments)
        before = (topic.name, topic.resolved_name, topic.type, topic.md5sum, topic.reg_type, topic.data_class.__name__)
        listed = (
            [name for name, _ in get_topic_manager().get_publications() if name != "/rosout"],
            topic.get_num_connections(),
        )
        topic.unregister()
        topic.unregister()
        return before, listed, topic.impl

    t("topic", show)

# Logs
lines = []


class Keep(logging.Handler):
    def emit(self, record):
        late = (
            "_connect_topic_thread" in record.funcName
        )  # stock's may notice in another thread that a topic above ended
        if not late and (record.name.startswith("rosout") or record.name == "rospy.internal"):
            lines.append((record.name, record.levelname, record.getMessage(), record.funcName, record.lineno - start))


start = 0
logging.getLogger("rosout").setLevel(logging.DEBUG)
rosout = logging.getLogger("rosout")
for handler in rosout.handlers[:]:  # that of the terminal
    rosout.removeHandler(handler)
rosout.addHandler(Keep())
logging.getLogger("rospy").addHandler(Keep())
logging.getLogger("rospy").setLevel(logging.DEBUG)
said = sys.stdout, sys.stderr
for name in ("debug", "info", "warn", "err", "fatal"):
    plain, throttled, identical, once = (
        getattr(rospy, f"log{name}{kind}") for kind in ("", "_throttle", "_throttle_identical", "_once")
    )
    lines.clear()
    plain("plain %s %d", "a", 1)
    for number in range(3):
        throttled(1000, "throttled %d", number)
        throttled(0, "never throttled")
        identical(1000, "identical %d", number // 2)
        once("once %d", number)
    plain("named", logger_name="other")
    once("elsewhere")
    print(name, [line[:4] for line in lines])
    t("few", lambda: throttled("text"))
    t("wrong", lambda: plain("%d", "x"))
    t("wrong", lambda: plain())
WORDS = """
logdebug_throttle loginfo_throttle logwarn_throttle logerr_throttle logfatal_throttle
logdebug_throttle_identical loginfo_throttle_identical logwarn_throttle_identical logerr_throttle_identical
logfatal_throttle_identical logdebug_once loginfo_once logwarn_once logerr_once logfatal_once
"""
for word in WORDS.split():
    arguments = "'text %d', number // 2" if "once" in word else "100.0, 'text %d' % (number // 2)"
    place = compile(f"rospy.core.{word}({arguments})", word, "exec")  # a place of its own in the program
    lines.clear()
    for number in range(4):
        exec(place)
    print(word, [line[1:4] for line in lines])
lines.clear()
for function in (
    rospy.core.rospydebug,
    rospy.core.rospyinfo,
    rospy.core.rospywarn,
    rospy.core.rospyerr,
    rospy.core.logerror,
    rospy.logout,
):
    function("inner %s", 1)
print([line[:3] for line in lines])
throttle, other, first = rospy.core.LoggingThrottle(), rospy.core.LoggingIdentical(), rospy.core.LoggingOnce()
print([bool(throttle("place", 1000)) for _ in range(3)], [bool(throttle("place 2", 0)) for _ in range(3)])
print([bool(other("place", text)) for text in ("a", "a", "b", "b", "a")], [bool(first("place")) for _ in range(3)])
print(
    "place" in throttle.last_logging_time_table,
    "place" in other.last_logging_msg_table,
    "place" in first.called_caller_ids,
)
print(
    type(throttle.last_logging_time_table).__name__,
    type(first.called_caller_ids).__name__,
    rospy.core.LoggingOnce().called_caller_ids is first.called_caller_ids,
)

# Signals
before = signal.getsignal(signal.SIGTERM)
signal.signal(signal.SIGTERM, signal.SIG_DFL)
t("register", rospy.core.register_signals)
print(callable(signal.getsignal(signal.SIGTERM)), before is not signal.SIG_DFL)
inside = threading.Thread(target=lambda: t("in a thread", rospy.core.register_signals))
inside.start()
inside.join()

# Services
manager = (
    rospy.service.get_service_manager() if hasattr(rospy.service, "get_service_manager") else get_service_manager()
)


def provided():
    return sorted(
        pair for pair in manager.get_services() if "get_loggers" not in pair[0] and "set_logger" not in pair[0]
    )


services = [rospy.Service(name, kind, lambda request: []) for name, kind in (("one", Empty), ("~two", Trigger))]
print(clean(provided()))
t("get", lambda: manager.get_service("/one") is services[0])
t("get", lambda: manager.get_service("one"))
t("get", lambda: manager.get_service(None))
t("again", lambda: rospy.Service("one", Empty, lambda request: []))
t("register", lambda: manager.register("/one", services[1]))
t("unregister", lambda: manager.unregister("/one", services[1]))
t("unregister", lambda: manager.unregister("/no", services[1]))
print(clean(provided()))
t("all", manager.unregister_all)
print(clean(provided()), manager.get_service("/one"))
t("wait", lambda: rospy.wait_for_service("one", 0.05))
own = rospy.service.ServiceManager()
print(own.get_services(), own.get_service("/x"))
t("all", own.unregister_all)

# Names of the node
print(rospy.names.get_mappings(), rospy.names.get_resolved_mappings())
t("resolved", lambda: rospy.names.valid_name_validator_resolved("p", "~x", rospy.get_name()))
for name in ("~x", "x", "/x", "", None, 3, "a b"):
    for left in (rospy.search_param("x"), rospy.search_param("a b"), rospy.search_param("3")):
        if left:
            rospy.delete_param(left)
    t("search", lambda: rospy.search_param(name))
    t("has", lambda: rospy.has_param(name))
    t("get", lambda: type(rospy.get_param(name, "default")))
    t("delete", lambda: rospy.delete_param(name) if name else None)
    t("resolve", lambda: rospy.resolve_name(name))
    t("remap", lambda: rospy.remap_name(name))
    t("publisher", lambda: rospy.Publisher(name, String, queue_size=1).resolved_name)
    t("subscriber", lambda: rospy.Subscriber(name, String).resolved_name)
    t("service", lambda: rospy.Service("s" if name == "x" else name, Empty, None).resolved_name)
    t("proxy", lambda: rospy.ServiceProxy(name, Empty).resolved_name)
    t("published", lambda: type(rospy.get_published_topics(name)))
for arguments in (("a",), (Header(),), (3,), ("a", 4), ()):
    t("call", lambda: rospy.ServiceProxy("nobody", Empty)(*arguments))
    t("call", lambda: rospy.ServiceProxy("nobody", Empty).call(*arguments))
    t("call", lambda: rospy.ServiceProxy("nobody", Trigger)(*arguments))
publisher = rospy.Publisher("/publisher", String, queue_size=1)
for arguments, words in (
    (("a",), {}),
    ((Header(),), {}),
    ((3,), {}),
    (("a", 4), {}),
    ((), {}),
    ((), {"data": "a"}),
    ((), {"no": 1}),
    (("a",), {"data": "b"}),
    ((String(3),), {}),
    ((None,), {}),
    ((String,), {}),
    (([1],), {}),
    ((b"x",), {}),
):
    t(f"publish {len(arguments)}", lambda: publisher.publish(*arguments, **words))
