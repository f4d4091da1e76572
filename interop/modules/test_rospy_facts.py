"""Facts on rospy that the files beside this one do not look at: the same program on stock's modules and on ours."""

from __future__ import annotations

import os
import pty
import re
import subprocess
from pathlib import Path

import pytest
from faces import FACES, command, environ, run, same, start
from harness import Master, free_port
from rospy_programs import TOOLS

HEAD = "import rospy\n" + TOOLS

MASTERS = ("ours",)

STARTED = """
import glob, rosgraph
rospy.set_param("/use_sim_time", True)
rospy.init_node("started", ["p", "_own:=5"])
rospy.delete_param("/use_sim_time")
until(lambda: any("/clock" == topic for topic, _ in rospy.get_master().getSystemState()[2][1]))
published, subscribed, services = [
    sorted(name for name, nodes in part if "/started" in nodes) for part in rospy.get_master().getSystemState()[2]]
print(published, subscribed, services, rospy.get_param("~own"))
kinds = dict(rospy.get_master().getTopicTypes()[2])
print(kinds["/rosout"], rospy.get_node_uri().startswith("http://"))
from rosservice import get_service_type
print([get_service_type(name) for name in services])
rospy.logdebug("something")
logging.getLogger("rospy").info("into the file")
until(lambda: glob.glob(os.path.join(os.environ["ROS_LOG_DIR"], "started.log")))
"""


def test_what_init_node_makes(launcher: Master, tmp_path: Path) -> None:
    texts = [run(face, launcher, HEAD + STARTED, ROS_LOG_DIR=str(tmp_path / face)) for face in FACES]
    assert texts[0] == texts[1]
    assert "['/clock'] ['/started/get_loggers', '/started/set_logger_level'] 5" in texts[0]


@pytest.mark.parametrize("face", FACES)
def test_a_program_waits_for_a_master(launcher: Master, face: str) -> None:
    text = HEAD + "rospy.init_node('waits')\nprint('never')\n"
    program = start(face, launcher, text, ROS_MASTER_URI=f"http://localhost:{free_port()}/")
    program.wait_line("Unable to (immediately )?register with master node", timeout=30)
    program.signal(2)
    program.wait()
    assert "never" not in program.transcript()


REFUSED = """
rospy.init_node("refused")
strings = rospy.Publisher("strings", String, queue_size=5)
points = rospy.Publisher("points", Point, queue_size=5)
def kind(publisher, *args):
    try:
        return publisher.publish(*args)
    except Exception as error:
        return [each.__name__ for each in type(error).__mro__ if each.__module__.startswith("rospy")] or type(error).__name__
wrong = ((strings, String(5)), (strings, 5), (points, "x", 1, 2), (points, Point(None, 1, 2)))
print([kind(*each) for each in wrong])
subscribers = [rospy.Subscriber("strings", String), rospy.Subscriber("points", Point)]
until(lambda: strings.get_num_connections() and points.get_num_connections())
print([kind(*each) for each in wrong])
"""


def test_wrong_values_are_refused_if_someone_listens(launcher: Master) -> None:
    assert "ROSSerializationException" in same(launcher, HEAD + REFUSED)


SHARED = """
rospy.init_node("shared")
one = rospy.Publisher("x", String, queue_size=5)
other = rospy.Publisher("x", Int32, queue_size=7, latch=True)
print(one.impl is other.impl, one.impl.data_class is String, other.data_class is Int32, one.impl.is_latch)
print(dict(rospy.get_published_topics())["/x"])
a = rospy.Subscriber("x", String, lambda message: None)
b = rospy.Subscriber("x", Int32, lambda message: None)
print(a.impl is b.impl, a.impl.data_class is String, a.impl.ref_count)
a.unregister()
print(b.impl.ref_count, rospy.topics.get_topic_manager().has_subscription("/x"))
b.unregister()
print(rospy.topics.get_topic_manager().has_subscription("/x"))
"""


def test_the_first_class_of_a_topic_stays(launcher: Master) -> None:
    assert "True True True True" in same(launcher, HEAD + SHARED)


CACHED = """
rospy.init_node("cached")
for _ in range(2):
    t("unset", lambda: rospy.get_param_cached("~unset"))
rospy.set_param("~empty", {})
t("empty", lambda: rospy.get_param("~empty"))
t("empty", lambda: rospy.get_param_cached("~empty"))
t("empty", lambda: rospy.get_param_cached("~empty", 3))
rospy.set_param("~unset", 4)
until(lambda: rospy.get_param_cached("~unset", None) == 4)
t("set", lambda: (rospy.get_param_cached("~unset"), rospy.get_param("~unset")))
rospy.delete_param("~unset")
"""


def test_copies_of_parameters_that_are_not_set(launcher: Master) -> None:
    assert "KeyError" in same(launcher, HEAD + CACHED)


DEAD = """
import rosgraph
rospy.init_node("asks")
rosgraph.Master("/dead").registerService("/dead", "rosrpc://localhost:1", "http://localhost:1")
t("wait", lambda: rospy.wait_for_service("dead", 0.6))
t("wait", lambda: rospy.ServiceProxy("dead", Empty).wait_for_service(timeout=0.4))
try:
    rospy.ServiceProxy("dead", Empty)()
except rospy.ServiceException as error:
    print("refused" in str(error))
"""


def test_a_service_that_nobody_serves(launcher: Master) -> None:
    assert "timeout exceeded" in same(launcher, HEAD + DEAD)


TIMES = """
for cls in (rospy.Time, rospy.Duration):
    for args in ((), (1,), (1, 2), (1.5,), (1.5, 1), (0, 2 * 10**9), (1, -1), (-1,), (-0.5,), (None,)):
        try:
            made = cls(*args)
            print(cls.__name__, args, made.secs, made.nsecs, str(made), made.to_sec(), made.to_nsec(), made.is_zero(), bool(made))
        except Exception as error:
            print(cls.__name__, args, type(error).__name__)
import operator
values = [rospy.Time(3, 5), rospy.Time(3, 5), rospy.Time(4), rospy.Duration(2, 5), rospy.Duration(-1), rospy.Duration(2, 5), 2,
          0.5, "a", None]
for name in ("add", "sub", "mul", "truediv", "floordiv", "lt", "le", "eq", "ne", "gt", "ge"):
    for a in values[:6]:
        for b in values:
            for left, right in ((a, b), (b, a)):
                try:
                    result = getattr(operator, name)(left, right)
                    print(name, left, right, type(result).__name__, result)
                except Exception as error:
                    print(name, left, right, type(error).__name__)
print(len({rospy.Time(3, 5), rospy.Time(3, 5), rospy.Duration(3, 5)}), rospy.Time.from_sec(1.25), rospy.Time(2).to_time())
"""


def test_values_and_calculations_of_time(master: Master) -> None:
    assert same(master, HEAD + TIMES).count("TypeError") > 50


JUMPS = """
from rosgraph_msgs.msg import Clock
rospy.set_param("/use_sim_time", True)
rospy.init_node("jumps")
rospy.delete_param("/use_sim_time")
clock = rospy.Publisher("/clock", Clock, queue_size=100)
until(lambda: clock.get_num_connections())
def tick(seconds):
    clock.publish(rospy.Time(seconds))
    until(lambda: rospy.get_time() == seconds)
tick(100)
lasting = []
kept = rospy.Timer(rospy.Duration(1), lasting.append, reset=True)
rates = []
def rate(reset):
    try:
        made = rospy.Rate(0.01, reset=reset)
        made.sleep()
        rates.append((reset, "slept"))
    except rospy.ROSTimeMovedBackwardsException as error:
        rates.append((reset, error.time < 0))
threads = [threading.Thread(target=rate, args=(reset,), daemon=True) for reset in (False, True)]
for thread in threads:
    thread.start()
now = 100
def on():
    global now
    now += 0.5
    tick(now)
    time.sleep(0.02)
def called():
    on()
    return lasting
until(called)
throttled = []
def say():
    rospy.loginfo_throttle(1000, "throttled")
for _ in range(3):
    say()
until(lambda: all(map(asleep, threads)))
tick(10)
now = 10
say()
say()
print("timer", kept.is_alive())
threads[0].join(20)
count = len(lasting)
def again():
    on()
    return len(lasting) > count
until(again)
kept.shutdown()
def slept():
    global now
    now += 20
    tick(now)
    return len(rates) == 2
until(slept)
print(sorted(rates))
"""


def test_time_that_jumps_back(launcher: Master) -> None:
    said = same(launcher, HEAD + JUMPS, ROSCONSOLE_FORMAT="${message}")
    assert said.count("throttled\n") == 2 and "timer True" in said


COLOURS = """
rospy.init_node("colours", log_level=rospy.DEBUG)
for level in ("logdebug", "loginfo", "logwarn", "logerr", "logfatal"):
    getattr(rospy, level)("level %s", level)
"""


def test_colours_of_a_terminal(launcher: Master) -> None:
    said = []
    for face in FACES:
        program = launcher.home / f"colours_{face}.py"
        program.write_text(HEAD + COLOURS)
        outside, inside = pty.openpty()
        try:
            variables = environ(face, launcher, ROSCONSOLE_FORMAT="${severity} ${message}", TERM="xterm")
            subprocess.run(
                command(face, program),
                env=variables,
                stdin=inside,
                stdout=inside,
                stderr=inside,
                timeout=60,
                check=True,
            )
            os.write(inside, b"THE END")
            text = b""
            while not text.endswith(b"THE END"):
                text += os.read(outside, 65536)
        finally:
            os.close(outside)
            os.close(inside)
        said.append([line for line in text.decode().splitlines() if "level log" in line])
        said[-1] = [line.replace("\x1b[0m", "") for line in said[-1]]  # it is before or after the end of the line
    assert said[0] == said[1]
    assert [re.findall(r"\x1b\[(\d+)m", line) for line in said[0]][2:] == [["33"], ["31"], ["31"]]


LOGGERS = """
rospy.init_node("loggers")
print(len(logging.getLogger("rosout").handlers) > 0, logging.getLogger("rosout").level, logging.getLogger().level)
from roscpp.srv import GetLoggers, SetLoggerLevel
get, set = rospy.ServiceProxy("~get_loggers", GetLoggers), rospy.ServiceProxy("~set_logger_level", SetLoggerLevel)
names = [logger.name for logger in get().loggers]
print([name in names for name in ("rosout", "rospy", "rospy.topics", "rospy.internal", "rospy.service")])
for name in ("rospy", "rospy.topics", "never.made"):
    set(name, "error")
    print(logging.getLogger(name).level, [each.level for each in get().loggers if each.name == name])
print([getattr(rospy, name) for name in ("DEBUG", "INFO", "WARN", "ERROR", "FATAL")])
"""


def test_loggers_and_files(launcher: Master) -> None:
    assert "[1, 2, 4, 8, 16]" in same(launcher, HEAD + LOGGERS)


NAMES = """
import rospy.service
for name in ("ROSException", "ROSSerializationException", "ROSInitException", "ROSInterruptException", "ROSInternalException",
             "ROSTimeMovedBackwardsException", "TransportException", "TransportTerminated", "TransportInitError"):
    print(name, [each.__name__ for each in getattr(rospy.exceptions, name).__mro__], getattr(rospy, name).__name__)
print([each.__name__ for each in rospy.service.ServiceException.__mro__])
print(sorted(rospy.__all__))
starred = {}
exec("from rospy import *", starred)
print(sorted(name for name in starred if name != "__builtins__"))
print([hasattr(rospy, name) for name in ("wait_for_message", "Timer", "ROSTimeMovedBackwardsException", "loginfo_throttle_identical",
      "client", "core", "exceptions", "impl", "msg", "msproxy", "names", "rostime", "service", "timer", "topics")])
"""


def test_exceptions_and_names(master: Master) -> None:
    assert "'Exception', 'KeyboardInterrupt'" in same(master, HEAD + NAMES)


LIBRARIES = """
import importlib
for name in ("actionlib", "diagnostic_updater", "dynamic_reconfigure.client", "dynamic_reconfigure.server", "genpy", "message_filters",
             "rosbag", "rosgraph", "roslaunch", "roslib.message", "rosmsg", "rosnode", "rosparam", "rospkg", "rosservice", "rostopic",
             "std_msgs.msg", "tf", "tf.transformations", "tf2_ros"):
    print(importlib.import_module(name).__name__)
import genpy, message_filters, rosgraph, roslib, roslib.message, rospkg, tf, tf2_ros
print(roslib.message.get_message_class("std_msgs/String") is String, roslib.message.get_message_class("std_msgs/Nothing"))
t("manifest", lambda: roslib.load_manifest("rospy"))
print(issubclass(String, genpy.Message), rospkg.RosPack.__name__)
print(rosgraph.is_master_online(), rosgraph.get_master_uri() == os.environ["ROS_MASTER_URI"], rosgraph.myargv(["p", "a:=b", "c"]))
master = rosgraph.Master("/asks")
print(rosgraph.is_master_online(), master.getPid() > 0)
for ask in (lambda: master.lookupNode("/nobody"), lambda: master.lookupService("/none"), lambda: master.getParam("/none")):
    try:
        ask()
    except rosgraph.MasterException as error:
        print(type(error).__name__)
for cls in (message_filters.Cache, message_filters.TimeSynchronizer, message_filters.ApproximateTimeSynchronizer):
    import inspect
    print(cls.__name__, list(inspect.signature(cls).parameters))
for name in ("LookupException", "ConnectivityException", "ExtrapolationException", "InvalidArgumentException", "TimeoutException"):
    print(name, [each.__name__ for each in getattr(tf2_ros, name).__mro__][1:2])
for name in ("Buffer", "TransformListener", "TransformBroadcaster", "StaticTransformBroadcaster", "BufferClient", "BufferInterface"):
    print(hasattr(tf2_ros, name), hasattr(tf, name))
"""


def test_libraries_beside_rospy(launcher: Master) -> None:
    assert "MasterError" in same(launcher, HEAD + LIBRARIES)
