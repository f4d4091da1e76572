"""Small things that programs see of rospy and its siblings: the topic /rosout, errors of callbacks as records of
Python's logger, times from texts, definitions of services in odd forms."""

from __future__ import annotations

import pytest
from faces import same
from harness import Master
from rospy_programs import TOOLS

MASTERS = ("ours",)

ROSOUT = """
from rosgraph_msgs.msg import Log
from rospy.topics import get_topic_manager
rospy.init_node("rest")
manager = get_topic_manager()
impl = manager.get_publisher_impl("/rosout")
until(impl.get_num_connections)
t("impl", lambda: (impl.name, impl.resolved_name, impl.type, impl.is_latch, impl.ref_count, impl.queue_size, impl.closed))
t("topics", lambda: (manager.get_publications(), manager.get_topics(), manager.has_publication("/rosout")))
t("connections", lambda: [each[2:5] for each in manager.get_pub_sub_info()])
got = []
rospy.Subscriber("/rosout", Log, lambda message: message.name == "/rest" and got.append(message.msg))
own = rospy.Publisher("/rosout", Log, queue_size=10)
until(lambda: impl.get_num_connections() > 1)
own.publish(Log(msg="own", name="/rest"))
until(lambda: "own" in got)
own.unregister()
rospy.logerr("logged")
until(lambda: "logged" in got)
t("left", lambda: (impl.ref_count, manager.has_publication("/rosout"), got.count("logged")))
"""

CALLBACKS = """
rospy.init_node("callbacks")
told = []
class Told(logging.Handler):
    def emit(self, record):
        text = record.getMessage()
        if text.startswith("bad callback"):
            told.append((record.name, record.levelname, text.splitlines()[0].split(" at 0x")[0], text.splitlines()[1], text.strip().splitlines()[-1]))
logging.getLogger("rosout").addHandler(Told())
def wrong(message):
    raise RuntimeError(message.data)
class Object:
    def method(self, message, extra):
        raise ValueError(extra)
    def __call__(self, message):
        return message.nothing
# A topic each, since a connection that has just ended can take a new one with it in rospy (T63).
for topic, callback, extra in (("t1", wrong, None), ("t2", Object().method, "more"), ("t3", len, None)):
    p, s = rospy.Publisher(topic, String, queue_size=1), rospy.Subscriber(topic, String, callback, extra)
    until(lambda: p.get_num_connections() and s.get_num_connections())
    p.publish("data")
    until(lambda: told)
    print(told)
    told.clear()
    p.unregister(), s.unregister()
"""

TIMES = """
import genpy
for cls in (rospy.Time, rospy.Duration, genpy.Time, genpy.Duration):
    for given in (("a",), (1, "b"), ("1",), ("",), (b"x",), (None,), ([],), (1j,), (1.5, 2), (1, 2.5), (-1,), (0, -1), (True,), (1, None)):
        try:
            print(cls.__name__, given, repr(cls(*given)))
        except Exception as error:
            print(cls.__name__, given, type(error).__name__)
"""

SERVICES = """
import random
import genmsg, roslib.srvs
dice = random.Random(7)
LINES = ["int8 a", "string b", "---", "----", "--- x", "#---", "", "int8 X=3", "float64[3] c  # d"]
for turn in range(200):
    text = "\\n".join(dice.choices(LINES, k=dice.randrange(6)))
    context = genmsg.msg_loader.MsgContext.create_default()
    try:
        spec = genmsg.msg_loader.load_srv_from_string(context, text, "p/S")
        print(repr(text), spec.request.fields(), repr(spec.request.text), spec.response.fields(), repr(spec.response.text))
        print(genmsg.gentools.compute_md5(context, spec), str(roslib.srvs.load_from_string(text, "p", "S")))
    except genmsg.InvalidMsgSpec as error:
        print(repr(text), type(error).__name__)
"""

ARGUMENTS = """
sys.argv += ["_empty:=", "_blank:= ", "__name:=", "chatter:=", "_full:=x", ":=", "word"]
rospy.init_node("arguments")
for name in ("empty", "blank", "full"):
    t(name, lambda: rospy.get_param("~" + name))
t("names", lambda: (rospy.get_name(), rospy.Publisher("chatter", String, queue_size=1).name))
t("arguments", lambda: (rospy.myargv()[1:], rospy.names.get_mappings(), rospy.names.get_resolved_mappings()))
"""

VALUES = """
from geometry_msgs.msg import PoseStamped, Twist, PolygonStamped, Point32
from sensor_msgs.msg import JointState, Image, LaserScan
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from diagnostic_msgs.srv import AddDiagnostics
from nav_msgs.msg import Path
rospy.init_node("wrong")
i=0
def each(*messages):
    # one publisher for each, since stock's is broken after an error
    global i
    for m in messages:
        i += 1
        p = rospy.Publisher("s%d" % i, type(m), queue_size=5); s = rospy.Subscriber("s%d" % i, type(m), lambda x: 0)
        until(lambda: p.get_num_connections() and s.get_num_connections())
        try: p.publish(m); print(i, "ok")
        except Exception as error: print(i, type(error).__name__)
ps = PoseStamped(); ps.header = None
ps2 = PoseStamped(); ps2.pose.position = None
ps3 = PoseStamped(); ps3.header.frame_id = b"map"
ps4 = PoseStamped(); ps4.header.stamp = 5
ps5 = PoseStamped(); ps5.header.stamp = None
ps6 = PoseStamped(); ps6.pose.position.x = "1"
ps7 = PoseStamped(); ps7.header.frame_id = None
ps8 = PoseStamped(); ps8.header.frame_id = 5
each(ps, ps2, ps3, ps4, ps5, ps6, ps7, ps8, String("\\udce4"), String(b"x"), JointState(name=[b"a"]),
    JointState(name=["\\ud800"]), JointState(name=None), JointState(name=[5]), JointState(name="abc"),
    JointState(position=["a"]), JointState(position=5), JointState(position=[None]),
    DiagnosticArray(status=[5]), DiagnosticArray(status=[DiagnosticStatus(name=b"x")]),
    DiagnosticArray(status=[DiagnosticStatus(values=[KeyValue("a", 5)])]),
    DiagnosticArray(status=[DiagnosticStatus(values=[KeyValue("a", None)])]), Image(data="abc"),
    Image(data=[1,2]), Image(data=[300]), Image(data=None), Image(height=-1), Image(height=2**33),
    Image(height=1.5), LaserScan(ranges=(1,2)), Path(poses=[ps]), Path(poses=None), Path(poses=ps2),
    Twist(linear=5), Int32(2**31), Int32("1"), Int32(None), Float64("x"), Float64(None), Float64(1),
    PolygonStamped())
rospy.Service("sv", AddDiagnostics, lambda r: (True, "x"))
for v in (b"x", "\\udce4", 5, None, "ok"):
    try: print(rospy.ServiceProxy("sv", AddDiagnostics)(v))
    except Exception as error: print(type(error).__name__)
"""

LOGGING = """
import tempfile
folder = tempfile.TemporaryDirectory()
file = os.path.join(folder.name, "python_logging.conf")
with open(file, "w") as writer:
    writer.write('''[loggers]
keys=root, rosout
[handlers]
keys=fileHandler,streamHandler
[formatters]
keys=defaultFormatter
[logger_root]
level=INFO
handlers=fileHandler
[logger_rosout]
level=INFO
handlers=streamHandler
propagate=1
qualname=rosout
[handler_fileHandler]
class=handlers.RotatingFileHandler
level=DEBUG
formatter=defaultFormatter
args=(os.environ['ROS_LOG_FILENAME'],'a', 50000000, 4)
[handler_streamHandler]
class=rosgraph.roslogging.RosStreamHandler
level=DEBUG
formatter=defaultFormatter
args=(True,)
[formatter_defaultFormatter]
format=[%(name)s][%(levelname)s] %(message)s
''')
os.environ["ROS_PYTHON_LOG_CONFIG_FILE"] = file
os.environ["ROSCONSOLE_FORMAT"] = "${severity}|${node}|${logger}|${function}|${message}"
os.environ["ROS_LOG_DIR"] = os.path.join(folder.name, "log")
rospy.init_node("configured")
print(os.path.relpath(os.environ["ROS_LOG_FILENAME"], folder.name))
def speak():
    rospy.logdebug("not shown")
    rospy.loginfo("information %d", 5)
    rospy.loginfo("named", logger_name="sub")
    rospy.logwarn("warning")
    logging.getLogger("other").warning("of another library")
speak()
sys.stdout.flush()
with open(os.environ["ROS_LOG_FILENAME"]) as reader:
    print(*[line for line in reader.read().splitlines() if line[:2] == "[o" or line.startswith("[rosout")], sep="\\n")
"""


@pytest.mark.parametrize(
    "program",
    [ROSOUT, CALLBACKS, TIMES, SERVICES, ARGUMENTS, VALUES, LOGGING],
    ids=["rosout", "errors of callbacks", "times", "services", "empty arguments", "wrong values", "logging"],
)
def test_the_same_as_stock(master: Master, program: str) -> None:
    # They print the transport of links, which is stock's here.
    lines = same(master, "import rospy\n" + TOOLS + program, PYROS1_TRANSPORTS="tcp").splitlines()
    assert len(lines) > 2
