"""Private places of rospy that programs reach into: what is there is as in stock ROS; the rest raises an error that says so."""

from __future__ import annotations

from pathlib import Path

import pytest
from faces import run, same
from harness import Master
from rospy_programs import TOOLS

MASTERS = ("ours",)

PROGRAM = """
import rospy.impl.registration, rospy.rostime, rospy.core, rospy.client
rospy.init_node("private")
service = rospy.Service("switch", Empty, lambda request: [])
proxy = rospy.ServiceProxy("switch", Empty, persistent=True)
print(proxy.seq, proxy.uri)
print(proxy._get_service_uri(EmptyRequest()) == rospy.get_master().lookupService("switch")[2])
proxy()
print(proxy.seq, proxy.uri == service.uri)
proxy.close()
t("none", lambda: rospy.ServiceProxy("none", Empty)._get_service_uri(EmptyRequest()))
once = rospy.ServiceProxy("switch", Empty)
print(once(), once.seq, once.uri == service.uri)
got = []
subscriber = rospy.Subscriber("words", String, lambda message, more: got.append((message.data, more)), "more")
publisher = rospy.Publisher("words", String, queue_size=1)
until(publisher.get_num_connections)
print(publisher.impl.publish(String("by impl")), publisher.impl.handler, subscriber.impl.handler)
until(lambda: got)
subscriber.impl.receive_callback([String("a"), String("b")], None)
print(got)
print(rospy.rostime._rostime_current, rospy.rostime._rostime_initialized)
print(rospy.core._uri == rospy.get_node_uri())
print(rospy.names._caller_namespace, rospy.names._caller_id, rospy.names._mappings, rospy.names._resolved_mappings)
print(type(rospy.client._master_proxy).__name__, type(rospy.client._param_server).__name__)
print(isinstance(publisher.impl, rospy.topics._TopicImpl), isinstance(subscriber.impl, rospy.topics._SubscriberImpl))
try:
    rospy.get_master().nope()
except Exception as error:
    print(type(error).__name__, error.faultCode)
print(rospy.get_master().target.getUri("/private") == rospy.get_master().getUri())
rospy.set_param("", "x")
from io import BytesIO
from std_msgs.msg import Float32, Float32MultiArray
listener = rospy.Subscriber("small", Float32)
small = rospy.Publisher("small", Float32, queue_size=1)
until(small.get_num_connections)
for call in (lambda: small.publish(1e40), lambda: Float32MultiArray(data=[1, -1e39]).serialize(BytesIO())):
    try:
        call()
    except OverflowError:
        print("overflow")
rospy.signal_shutdown("over")
publisher.publish("late")
"""


def test_what_is_there(master: Master) -> None:
    assert "overflow" in same(master, "import rospy\n" + TOOLS + PROGRAM)


def test_a_message_after_the_end_is_not_logged(master: Master) -> None:
    program = """
import sys, threading, rospy
from std_msgs.msg import String
sys.stderr = sys.stdout
threading.excepthook = lambda failure: None  # stock's thread that accepts connections may fail as it ends
rospy.init_node("late")
publisher = rospy.Publisher("late_words", String, queue_size=1)
rospy.signal_shutdown("over")
publisher.publish("late")
"""
    assert "late" not in same(master, program)


@pytest.mark.parametrize("words", ["", "__ns:=/mine"])
def test_the_namespace_of_the_argv_that_init_node_is_given(master: Master, words: str) -> None:
    program = 'import rospy\nrospy.init_node("named", argv=["x", "__ns:=/other"])\nprint(rospy.get_name())\n'
    assert same(master, program, *words.split()) == ("/mine/named\n" if words else "/named\n")


ABSENT = """
import rospy, rospy.impl.registration, rosbag
from std_msgs.msg import String
from std_srvs.srv import Empty
rospy.init_node("absent")
publisher, subscriber = rospy.Publisher("absent", String, queue_size=1), rospy.Subscriber("absent", String)
while not publisher.impl.connections or not subscriber.impl.connections:
    pass
service, proxy = rospy.Service("absent", Empty, len), rospy.ServiceProxy("absent", Empty)
with rosbag.Bag("absent.bag", "w") as bag:
    pass
for what, names in (
    (publisher.impl, "latch seq c_lock publock acquire release buff"),
    (subscriber.impl, "c_lock"),
    (publisher.impl.connections[0], "socket fileno protocol local_endpoint remote_endpoint cleanup_cb read_buff"),
    (subscriber.impl.connections[0], "socket fileno protocol local_endpoint remote_endpoint cleanup_cb read_buff"),
    (service, "protocol"),
    (proxy, "transport protocol"),
    (bag, "_connection_indexes _index_data_pos _curr_chunk_info"),
    (rospy.core, "_client_shutdown_hooks _preshutdown_hooks _shutdown_hooks"),
    (rospy.impl.registration, "RegManager get_registration_listeners"),
):
    for name in names.split():
        try:
            print(getattr(what, name), "is there")
        except AttributeError as error:
            print(error)
"""


def test_what_is_not_there_says_so(master: Master, tmp_path: Path) -> None:
    lines = run("ours", master, ABSENT.replace("absent.bag", str(tmp_path / "absent.bag"))).splitlines()
    assert len(lines) == 33
    assert [line for line in lines if not (line.startswith("pyros1 has no ") and ": " in line)] == []


IMPORTS = """
import importlib
for name in ("rosmaster rosclean roslz4 roswtf PyKDL rospy.impl.masterslave rospy.impl.tcpros_pubsub "
             "rospy.impl.udpros "
             "roslaunch.child roslaunch.remote rosunit.pmon kdl_parser_py").split():
    try:
        importlib.import_module(name)
    except ImportError as error:
        print(type(error).__name__, name in str(error) or error, "not part of pyros1: " in str(error)
              or "pyros1 has no" in str(error), ": " in str(error))
try:
    import PyKDL
except ImportError:
    PyKDL = None
try:
    from rospy.impl import masterslave
except ImportError as error:
    print(error)
"""


def test_packages_that_are_not_there_say_so(master: Master) -> None:
    lines = run("ours", master, IMPORTS).splitlines()
    assert lines[:-1] == ["ModuleNotFoundError True True True"] * 12
    assert "pyros1 has no rospy.impl.masterslave: " in lines[-1]


INNER = """
import inspect, sys
import rospy
sys.stderr = sys.stdout
print(rospy.impl.simtime._is_use_simtime.__name__, rospy.impl.simtime._ROSCLOCK, rospy.impl.simtime._USE_SIMTIME)
print(rospy.impl.simtime.init_simtime(), rospy.rostime.is_rostime_initialized(), rospy.get_time() > 1e9)
from rospy.impl.init import RosStreamHandler, start_node
print([*inspect.signature(start_node).parameters], RosStreamHandler.__name__)
from rospy.impl.tcpros import DEFAULT_BUFF_SIZE
"""


def test_inner_modules(master: Master) -> None:
    assert "RosStreamHandler" in same(master, INNER)
