"""rospy's publishers and subscribers: the same program on stock's modules and on ours, and one on each side
(P08-P17)."""

from __future__ import annotations

import itertools

import pytest
from faces import FACES, same, start
from harness import Master
from rospy_programs import TOOLS

HEAD = "import rospy\n" + TOOLS

MASTERS = ("ours",)
PAIRS = list(itertools.product(FACES, repeat=2))

PUBLISH = """
rospy.init_node("topics")
got = []
p = rospy.Publisher("x", String, queue_size=10)
t("nobody", lambda: (p.publish(5), p.publish(), p.publish(None), p.publish("a"), p.publish(data="b")))
for args, kwds in (((1, 2), {}), (("a",), {"data": "b"}), ((), {"dat": "b"}), ((Int32(4),), {}), ((Point(),), {})):
    t("wrong", lambda: p.publish(*args, **kwds))
q = rospy.Publisher("point", Point, queue_size=10)
for args, kwds in (((1, 2, 3), {}), ((1, 2), {}), ((1,), {}), ((String("a"),), {}), ((), {"z": 4}),
    ((PointStamped(),), {})):
    t("point", lambda: q.publish(*args, **kwds))
q = rospy.Publisher("stamped", PointStamped, queue_size=10)
for message in (Point(), PointStamped().header):
    t("first field", lambda: q.publish(message))
s = rospy.Subscriber("x", String, got.append)
until(lambda: p.get_num_connections() and s.get_num_connections())
for given in ("text", String("message"), "\\u00fc"):
    t("publish", lambda: p.publish(given))
until(lambda: len(got) >= 3)
print([message.data for message in got], sorted(got[-1]._connection_header))
print([type(message) is String for message in got], [str(message) for message in got])
t("publisher", lambda: (p.name, p.resolved_name, p.type, p.md5sum, p.data_class is String, p.reg_type))
t("impl", lambda: (p.impl.resolved_name, p.impl.name, p.impl.type, p.impl.has_connections(),
    p.impl.get_num_connections(),
                   p.impl.ref_count, p.impl.queue_size, p.impl.is_latch, p.impl.closed, p.impl.headers))
t("subscriber", lambda: (s.name, s.type, s.callback_args, s.reg_type, s.impl.queue_size, s.impl.buff_size,
                         s.impl.tcp_nodelay, len(s.impl.callbacks), s.impl.ref_count))
c = s.impl.connections[0]
t("connection", lambda: (c.direction, c.endpoint_id == rospy.get_node_uri(), c.name, c.type, c.done))
m = rospy.topics.get_topic_manager()
t("manager", lambda: ("/x" in m.get_topics(), ["/x", "std_msgs/String"] in m.get_publications(), m.get_subscriptions(),
                      m.has_publication("/x"), m.get_publisher_impl("/x") is p.impl, m.get_impl("sub", "/x") is s.impl))
p2 = rospy.Publisher("x", String, queue_size=5, latch=True)
t("shared", lambda: (p2.impl is p.impl, p.impl.ref_count, p.impl.is_latch, p.impl.queue_size))
p2.unregister()
t("gone", lambda: p2.publish("x"))
t("gone", lambda: (p2.impl, p2.unregister()))
t("gone", p2.get_num_connections)
t("still", lambda: p.publish("still"))
until(lambda: got[-1].data == "still")
p.unregister(), s.unregister()
t("all gone", lambda: (m.has_publication("/x"), m.has_subscription("/x"), rospy.get_published_topics("/x")))
"""

ARGUMENTS = """
rospy.init_node("more")
out = []
p = rospy.Publisher("many", Int32, queue_size=100, latch=True)
a = rospy.Subscriber("many", Int32, lambda m, extra: out.append(("a", m.data, extra)), "extra")
b = rospy.Subscriber("many", Int32, callback=lambda m, extra: out.append(("b", m.data, extra)), callback_args=(1, 2))
until(lambda: p.get_num_connections() == 1)
p.publish(7)
until(lambda: len(out) == 2)
late = rospy.Subscriber("many", Int32, lambda m: out.append(("late", m.data)))
until(lambda: len(out) == 3)
print(sorted(map(str, out)), p.get_num_connections(), a.get_num_connections())
a.unregister()
p.publish(8)
until(lambda: len(out) == 5)
print(sorted(map(str, out[3:])))
class Callable:
    def __call__(self, m):
        out.append(("object", m.data))
rospy.Subscriber("many", Int32, Callable())
until(lambda: len(out) == 6)
print(out[5])
t("wait", lambda: rospy.wait_for_message("many", Int32, 5).data)
t("wait", lambda: rospy.wait_for_message("silent", Int32, 0.1))
t("wait", lambda: rospy.wait_for_message("silent", Int32, rospy.Duration(0.1)))
t("wait", lambda: rospy.wait_for_message("silent", 5, 0.1))
raw = []
any_sub = rospy.Subscriber("any", rospy.AnyMsg, raw.append)
any_pub = rospy.Publisher("any", PointStamped, queue_size=10, headers={"own": "field"})
until(lambda: any_pub.get_num_connections())
any_pub.publish(PointStamped(Header(0, rospy.Time(3, 4), "frame"), Point(1, 2, 3)))
until(lambda: raw)
print(type(raw[0]).__name__, raw[0]._buff, raw[0]._connection_header["type"], raw[0]._connection_header.get("own"))
typed = PointStamped().deserialize(raw[0]._buff)
print(typed)
"""

CALLBACKS = """
rospy.init_node("callbacks")
first = rospy.Publisher("first", String, queue_size=10)
second = rospy.Publisher("second", String, queue_size=10)
done = threading.Event()
out = []
def wait(message):
    answer = rospy.wait_for_message("second", String, 10)
    out.append((message.data, answer.data, rospy.ServiceProxy("own", SetBool)(True).message))
    done.set()
service = rospy.Service("own", SetBool, lambda request: (request.data, "yes"))
s = rospy.Subscriber("first", String, wait)
until(lambda: first.get_num_connections() == 1)
first.publish("go")
while not done.is_set():
    second.publish("answer")
    time.sleep(0.02)
print(out)
bad = rospy.Subscriber("second", String, lambda message: 1 / 0)
good = rospy.Subscriber("second", String, lambda message: out.append("good"))
def both():
    second.publish("x")
    return out.count("good") >= 2
until(both)
"""

LISTENER = """
class Listener(rospy.SubscribeListener):
    def peer_subscribe(self, topic_name, topic_publish, peer_publish):
        print("came", topic_name, flush=True)
        peer_publish(String("to the new one"))
    def peer_unsubscribe(self, topic_name, num_peers):
        print("went", topic_name, num_peers, flush=True)
rospy.init_node("welcome")
p = rospy.Publisher("welcome", String, Listener(), queue_size=10)
print("ready", flush=True)
rospy.spin()
"""
HEAR = """
def say(*words):  # in one piece, whatever other threads print
    sys.stdout.write(" ".join(words) + "\\n")
    sys.stdout.flush()
rospy.init_node("hear", anonymous=True)
s = rospy.Subscriber("welcome", String, lambda m: say("got", m.data, m._connection_header["callerid"]))
say("ready")
rospy.spin()
"""

TALK = """
rospy.init_node("talk")
p = rospy.Publisher("talk", Float64, queue_size=100)
until(lambda: p.get_num_connections() == 1)
for k in range(100):
    p.publish(k / 8)
n = rospy.Publisher("numbers", PointStamped, queue_size=10, latch=True, headers={"more": "yes"})
for k in range(5):
    n.publish(PointStamped(Header(77, rospy.Time(k), "f"), Point(k, k, k)))
rospy.spin()
"""
LISTEN = """
rospy.init_node("listen")
out, points = [], []
s = rospy.Subscriber("talk", Float64, lambda m: out.append(m.data))
until(lambda: len(out) == 100)
assert out == [k / 8 for k in range(100)]
l = rospy.Subscriber("numbers", PointStamped, points.append)
until(lambda: points and points[-1].point.x == 4)
m = points[-1]
print(m.point.x, m.header.seq > 0, m.header.frame_id, m._connection_header["latching"], m._connection_header["more"])
"""

NUMPY = """
import numpy, io
from rospy.numpy_msg import numpy_msg
from std_msgs.msg import Float32MultiArray, UInt8MultiArray, Int16MultiArray
from sensor_msgs.msg import JointState, Image
rospy.init_node("numpy")
def show(value):
    if type(value) is bytes:
        return value
    return type(value).__name__, value.dtype, value.shape, value.flags.writeable, value.tolist()
for cls, values, kind in ((Float32MultiArray, [1.5, 2], numpy.float32), (Int16MultiArray, [-1, 300], numpy.int16),
                          (Float32MultiArray, [0], numpy.float32), (UInt8MultiArray, [1, 2], bytes)):
    got = []
    p = rospy.Publisher("np", numpy_msg(cls), queue_size=10)
    s = rospy.Subscriber("np", numpy_msg(cls), got.append)
    until(lambda: p.get_num_connections())
    p.publish(numpy_msg(cls)(data=bytes(values) if kind is bytes else numpy.array(values, dtype=kind)))
    until(lambda: got)
    print(cls.__name__, show(got[0].data), isinstance(got[0], cls), type(got[0]).__name__)
    b = io.BytesIO()
    got[0].serialize(b)
    print(b.getvalue(), show(numpy_msg(cls)().deserialize(b.getvalue()).data), numpy_msg(cls) is numpy_msg(cls))
    p.unregister(), s.unregister()
"""

DERIVED = """
import io, numpy
from std_msgs.msg import Float32MultiArray, String
from geometry_msgs.msg import Point, PointStamped
rospy.init_node("derived")
calls = []
class Text(String):
    def serialize(self, buff):
        calls.append("out")
        String.serialize(self, buff)
    def deserialize(self, data):
        calls.append("in")
        return String.deserialize(self, data)
class Where(PointStamped):
    def __init__(self, *args, **kwds):
        super().__init__(*args, **kwds)
        self.name = "somewhere"
    def sum(self):
        return self.point.x + self.point.y
class Array(Float32MultiArray):
    __slots__, _slot_types = Float32MultiArray.__slots__, Float32MultiArray._slot_types
    def serialize(self, buff):
        return self.serialize_numpy(buff, numpy)
    def deserialize(self, data):
        return self.deserialize_numpy(data, numpy)
def send(name, ours, theirs, message):
    got = []
    p = rospy.Publisher(name, ours, queue_size=10)
    s = rospy.Subscriber(name, theirs, got.append)
    until(lambda: p.get_num_connections() and s.get_num_connections())
    p.publish(message)
    until(lambda: got)
    print(ours.__name__, theirs.__name__, type(got[0]).__name__, calls)
    calls.clear()
    return got[0]
print(send("a", Text, Text, Text("x")).data)
print(send("b", String, Text, String("x")).data)
print(send("c", Text, String, Text("x")).data)
m = send("d", Where, Where, Where(point=Point(1, 2, 3)))
print(m.name, m.sum(), m.header.seq > 0)
m = send("e", PointStamped, Where, PointStamped(point=Point(1, 2, 3)))
print(m.name, m.sum())
m = send("f", Array, Array, Array(data=numpy.array([1, 2], dtype=numpy.float32)))
print(m.data.tolist())
"""


def test_publishing(launcher: Master) -> None:
    assert "is not an attribute of String" in same(launcher, HEAD + PUBLISH)


def test_arguments_of_subscribers(launcher: Master) -> None:
    assert "'late', 7" in same(launcher, HEAD + ARGUMENTS)


def test_callbacks_wait_for_others(launcher: Master) -> None:
    assert same(launcher, HEAD + CALLBACKS) == "[('go', 'answer', 'yes')]\n"


def test_numpy(launcher: Master) -> None:
    assert "float32" in same(launcher, HEAD + NUMPY)


def test_classes_that_programs_derive(launcher: Master) -> None:
    assert "somewhere 3.0" in same(launcher, HEAD + DERIVED)


@pytest.mark.parametrize(("publisher", "subscriber"), PAIRS)
def test_pairs(launcher: Master, publisher: str, subscriber: str) -> None:
    talker = start(publisher, launcher, HEAD + TALK)
    listener = start(subscriber, launcher, HEAD + LISTEN)
    listener.wait_line("4.0 True f 1 yes", timeout=30)
    assert listener.wait() == 0
    talker.signal(2)
    assert talker.wait() == 0


@pytest.mark.parametrize(("publisher", "subscriber"), PAIRS)
def test_listeners(launcher: Master, publisher: str, subscriber: str) -> None:
    welcome = start(publisher, launcher, HEAD + LISTENER)
    welcome.wait_line("ready")
    hear = start(subscriber, launcher, HEAD + HEAR)
    welcome.wait_line("came /welcome")
    hear.wait_line("got to the new one /welcome")
    other = start(subscriber, launcher, HEAD + HEAR)
    welcome.wait_line("came /welcome")
    other.wait_line("got to the new one /welcome")
    hear.signal(2)
    welcome.wait_line("went /welcome 1")
    assert hear.wait() == 0
    assert len([line for line in hear.transcript().splitlines() if "got to" in line]) == 1
