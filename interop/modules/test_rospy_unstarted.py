"""What tests of programs use of rospy and genpy without a node: messages, buffers, a clock that they set, names; with
odd arguments, too."""

from __future__ import annotations

import pytest
from faces import same
from harness import Master
from rospy_programs import TOOLS

MASTERS = ("ours",)

HEAD = """
import random, sys
import genpy, rospy, rospy.client, rospy.core, rospy.msg, rospy.names, rospy.rostime, rospy.topics
from io import BytesIO
from geometry_msgs.msg import PointStamped
""" + TOOLS.replace("import ", "import rospy, ", 1)

MESSAGES = """
def kind(call):
    try:
        return call()
    except Exception as error:
        return "wrong" if isinstance(error, (AttributeError, TypeError)) else type(error).__name__
any_message, empty, buffer = rospy.AnyMsg(), rospy.Message(), BytesIO()
print(isinstance(any_message, rospy.Message), isinstance(any_message, genpy.Message), issubclass(rospy.AnyMsg, genpy.Message))
print(any_message._buff, any_message._type, any_message._md5sum, any_message.__slots__)
print(kind(lambda: any_message.serialize(buffer)), buffer.getvalue())
try:
    any_message.serialize(buffer)
except rospy.ROSException as error:
    print(error)
print(kind(lambda: rospy.msg.serialize_message(buffer, 3, any_message)))
buffer = BytesIO()
any_message.deserialize(b"bytes").serialize(buffer)
print(buffer.getvalue(), any_message == rospy.AnyMsg().deserialize(b"bytes"), any_message == rospy.AnyMsg())
print(isinstance(kind(lambda: rospy.AnyMsg("text")), str))
print(empty.serialize(buffer), buffer.getvalue(), empty._connection_header, empty == rospy.Message(), empty.__getstate__())
print(kind(lambda: rospy.Message(1, 2)), kind(lambda: rospy.Message(a=1)), kind(lambda: rospy.Message(None)._connection_header))
class Own(genpy.Message):
    __slots__ = ["a", "b"]
print(Own(1, 2).b, Own(b=3).a, kind(lambda: Own(1)), kind(lambda: Own(c=1)), Own(1, 2) == Own(1, 2), Own(1, 2) == Own(2, 1))
class Raw(rospy.AnyMsg):
    pass
print(isinstance(Raw(), rospy.Message), Raw().deserialize(b"x")._buff)
for name in "serialize_message", "deserialize_messages", "args_kwds_to_message":
    function = getattr(rospy.msg, name)
    values = [None, 0, "x", String("s"), PointStamped(), String, BytesIO(), [], {}]
    for first in values:
        for second in values:
            for third in (None, String, String("s"), {}):
                print(name, values.index(first), values.index(second), str(third)[:20], kind(lambda: function(first, second, third)))
pointed = PointStamped()
pointed.header.frame_id = None
rospy.msg.serialize_message(buffer, 7, pointed)
print(pointed.header.seq, pointed.header.frame_id, buffer.getvalue())
"""

BUFFERS = """
rng = random.Random(int(sys.argv[1]))
for case in range(300):
    buffer, start = BytesIO(), rng.choice([0, 0, 0, 3])
    buffer.write(b"abc"[:start])
    for number in range(rng.randrange(5)):
        rospy.msg.serialize_message(buffer, number, String("x" * rng.randrange(9)))
    if rng.random() < 0.5:
        buffer.write(rng.choice([b"\\x05", b"\\x05\\0\\0\\0", b"\\x05\\0\\0\\0\\x01\\0\\0\\0", b"\\x05\\0\\0\\0\\x09\\0\\0\\0z"]))
    if rng.random() < 0.2:
        buffer.seek(-min(buffer.tell(), rng.randrange(6)), 1)
    queue = [String("old")] * rng.randrange(3)
    size, most = rng.choice([None, None, 1, 2]), rng.choice([None, None, 0, 1, 2])
    try:
        rospy.msg.deserialize_messages(buffer, queue, String, size, most, start)
    except genpy.DeserializationError:
        print("error")
    print(case, size, most, [message.data for message in queue], buffer.tell(), buffer.getvalue())
"""

TIMES = """
t("none", lambda: rospy.rostime._set_rostime(None))
t("set", lambda: rospy.rostime._set_rostime(genpy.Time(5)))
t("no clock", rospy.Time.now)
rospy.rostime.set_rostime_initialized(True)
t("now", lambda: (rospy.Time.now(), rospy.get_time(), rospy.rostime.is_wallclock(), rospy.rostime._rostime_current))
rospy.rostime._rostime_current += rospy.Duration(1)
t("more", rospy.get_rostime)
done, calls = [], []
def sleep():
    rospy.sleep(1.5)
    done.append(rospy.get_time())
    try:
        rospy.sleep(rospy.Duration(5))
    except rospy.ROSTimeMovedBackwardsException as error:
        done.append((str(error), error.time))
def called(event):
    calls.append((event.current_expected.to_sec(), event.current_real.to_sec()))
thread = threading.Thread(target=sleep)
thread.start()
timer = rospy.Timer(rospy.Duration(0.5), called, oneshot=True)
while not calls:  # until both sleep
    rospy.rostime._set_rostime(rospy.get_rostime() + rospy.Duration(0, 1000))
    time.sleep(0.001)
    if rospy.get_time() > 6.01:
        rospy.rostime._set_rostime(rospy.Time(7))
print(calls[0][1], len(done))
rospy.rostime._set_rostime(rospy.Time(8))
until(lambda: done and asleep(thread))
rospy.rostime._set_rostime(rospy.Time(2))
thread.join()
print(done)
rate = rospy.Rate(10)
t("left", rate.remaining)
t("condition", lambda: rospy.rostime._rostime_cond is rospy.rostime.get_rostime_cond())
rospy.rostime.switch_to_wallclock()
t("wall", lambda: (rospy.rostime.is_wallclock(), rospy.rostime._rostime_current, rospy.get_time() > 1e9))
"""

NAMES = """
t("before", lambda: (rospy.get_name(), rospy.get_namespace(), rospy.client._init_node_args))
for name in ("", "/a/b", "/c"):
    t("set", lambda: rospy.names._set_caller_id(name))
    t("said", lambda: (rospy.get_name(), rospy.get_namespace(), rospy.get_caller_id(), rospy.names._caller_id))
t("simple", lambda: [genpy.base.is_simple(each) for each in ("int8", "x", [], None)])
t("modules", lambda: [each.__name__ for each in (rospy.client.time, rospy.core.logging, rospy.msg.genpy, rospy.rostime.rospy,
                                                 rospy.core.rosgraph, rospy.topics.threading)])
class Shown(logging.Handler):
    def emit(self, record):
        print(record.levelname, record.getMessage())
logging.getLogger("rosout").addHandler(Shown())
def log(**options):
    rospy.core._base_logger("text %s", ("a",), {}, **options)
rospy.rostime.set_rostime_initialized(True)
for options in ({}, {"throttle": 10}, {"throttle": 10, "throttle_identical": True}, {"once": True}):
    for _ in range(2):
        log(level="warning", **options)
"""


@pytest.mark.parametrize("program", [MESSAGES, TIMES, NAMES], ids=["messages", "times", "names"])
def test_without_a_node(master: Master, program: str) -> None:
    same(master, HEAD + program)


@pytest.mark.parametrize("seed", range(3))
def test_buffers_of_messages(master: Master, seed: int) -> None:
    assert "'old'" in same(master, HEAD + BUFFERS, str(seed))
