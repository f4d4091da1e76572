"""Smaller names of libraries: diagnostic_updater, dynamic_reconfigure, topic_tools, tf, rosunit, rostest, message packages' helpers."""

import io
import re
import sys
import os
import numpy as np
import rospy
import diagnostic_updater
import dynamic_reconfigure
import tf
import topic_tools
import dynamic_reconfigure.client
import dynamic_reconfigure.encoding as encoding
import rostest
import rosunit
from rosunit import junitxml


def t(title, call, *arguments, **named):
    try:
        found = str(call(*arguments, **named))
    except Exception as error:
        found = f"{type(error).__name__}: {error}"
    print(title, re.sub(r" at 0x[0-9a-f]+|secs: [1-9][0-9]*|nsecs: [0-9]+", "", found).replace("\n", "|"), flush=True)


# diagnostics
w = diagnostic_updater.DiagnosticStatusWrapper(level=1, name="n", message="m")
w.add("k", "v")
w.add("x", 5.5)
buf = io.BytesIO()
t("ser", w.serialize, buf)
print(buf.getvalue())
v = diagnostic_updater.DiagnosticStatusWrapper()
t("de", lambda: v.deserialize(buf.getvalue()) is v)
t("same", lambda: (v.level, v.name, v.message, [(e.key, e.value) for e in v.values]))
buf2 = io.BytesIO()
t("sern", w.serialize_numpy, buf2, np)
print(buf2.getvalue() == buf.getvalue())
u = diagnostic_updater.DiagnosticStatusWrapper()
t("den", lambda: u.deserialize_numpy(buf.getvalue(), np) is u)
t("same", lambda: u == v)
t("text", str, u)


def fails(call, *arguments):
    """The texts of these errors are ours."""
    try:
        print(call(*arguments))
    except Exception as error:
        print(type(error).__name__)


fails(v.deserialize, b"abc")
fails(diagnostic_updater.DiagnosticStatusWrapper(level="x").serialize, io.BytesIO())
# reconfigure
print([c.__name__ for c in dynamic_reconfigure.DynamicReconfigureException.__mro__])
t("e", lambda: str(dynamic_reconfigure.DynamicReconfigureParameterException("text")))
t("e", lambda: repr(dynamic_reconfigure.DynamicReconfigureException("a", 1)))


def raises(e):
    try:
        raise e("x")
    except dynamic_reconfigure.DynamicReconfigureException as c:
        return type(c).__name__


for e in (
    dynamic_reconfigure.DynamicReconfigureException,
    dynamic_reconfigure.DynamicReconfigureParameterException,
    dynamic_reconfigure.DynamicReconfigureCallbackException,
):
    t("raise", raises, e)
tree = {
    "id": 0,
    "parent": 0,
    "name": "Default",
    "type": "",
    "parameters": [],
    "groups": [
        {
            "id": 1,
            "parent": 0,
            "name": "A",
            "groups": [{"id": 2, "parent": 1, "name": "B", "groups": [], "parameters": []}],
            "parameters": [],
        },
        {"id": 3, "parent": 0, "name": "C", "groups": [], "parameters": []},
    ],
}


def G(i, p, n):
    return {"id": i, "parent": p, "name": n}


for g in (G(2, 1, "B"), G(7, 3, "Z"), G(1, 9, "A"), G(9, 10, "X")):
    for ls in ([G(1, 9, "A"), G(9, 10, "X")], [G(9, 10, "X"), G(1, 9, "A"), G(2, 1, "B")], []):
        try:
            r = encoding.get_parents(g, {"group": ls})
            print("->", type(r).__name__, [x["name"] for x in r])
        except BaseException as ex:
            print("!!", type(ex).__name__, str(ex)[:100])
# tf
rospy.init_node("small_names", anonymous=True)
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

br = tf.TransformBroadcaster()
got = []
sub = rospy.Subscriber("/tf", TFMessage, got.append)
m = TransformStamped()
m.header.frame_id = "a"
m.child_frame_id = "b"
m.transform.rotation.w = 1
m.transform.translation.x = 4
import time

end = time.monotonic() + 30
while not got and time.monotonic() < end:
    br.sendTransformMessage(m)
    time.sleep(0.05)
print([(x.header.frame_id, x.child_frame_id, x.transform.translation.x) for x in got[0].transforms])
for T in (tf.Transformer(), tf.TransformerROS(), tf.TransformListener()):
    t("ded", T.setUsingDedicatedThread, True)
    t("ded", T.setUsingDedicatedThread, False)
    t("ded", T.setUsingDedicatedThread)


# topic tools
class Lazy(topic_tools.LazyTransport):
    def subscribe(self):
        print("subscribe")

    def unsubscribe(self):
        print("unsubscribe")


from std_msgs.msg import String

l = Lazy()
p = l.advertise("~out", String, queue_size=1)
t("sub", l.peer_subscribe, 1, 2, x=3)
t("unsub", l.peer_unsubscribe, 1)
# rosunit
for name in ("read_all", "cdata", "filter_nonprintable_text", "pattern"):
    print(name, getattr(junitxml, name, None) and True)
print(ascii(junitxml.pattern), [c.__name__ for c in junitxml.TestInfo.__mro__])


def w(f, *a):
    try:
        print(f(*a))
    except Exception as e:
        print(type(e).__name__)


@rostest.deprecated
def old(a, b=2):
    "It is old."
    print("called", a, b)
    return a


t("old", old, 1, b=3)
print(old.__name__, old.__doc__)
t("old", old)
for text in ("plain", "a\x00b", "\x1b[31mred\x1b[0m", "ü€", "a\nb\tc\r", "\ud800", "<&>]]>", "", "\x7f\x85\ufffe"):
    t("filter %a" % text, lambda: ascii(junitxml.filter_nonprintable_text(text)))
    t("cdata", lambda: ascii(junitxml.cdata(text)))
for cls in (junitxml.TestError, junitxml.TestFailure):
    for a in (("ty", "te\x00xt"), ("ValueError", 'a<b>&"c]]>'), ("", "")):
        t(cls.__name__, lambda: cls(*a).xml())
        t("el", lambda: __import__("xml.etree.ElementTree").etree.ElementTree.tostring(cls(*a).xml_element()))
c = junitxml.TestCaseResult("case")
c.time = 1.5
c.classname = "cls"
import xml.etree.ElementTree as ET

t("case", lambda: ET.tostring(c.xml_element()))
c.add_error(junitxml.TestError("T", "x"))
c.add_failure(junitxml.TestFailure("F", "y"))
t("case", lambda: ET.tostring(c.xml_element()))
t("case", c.xml)
t("props", lambda: (c.passed, c.description))
r = junitxml.Result("suite", 1, 1, 2)
r.time = 2.5
r.add_test_case_result(c)
t("r", lambda: (r.system_out, r.system_err))
r.system_out = "out\x00<"
r.system_err = "err"
print([n for n in dir(r) if n[0] != "_"], [n for n in dir(c) if n[0] != "_"])
t("x", lambda: junitxml.TestInfo("a", "b").text)
t("x", lambda: vars(junitxml.TestInfo("a", "b")))
r2 = junitxml.Result("b")
r2.accumulate(r)
t("acc", lambda: (r2.num_tests, r2.num_errors, r2.num_failures, r2.system_out, r2.system_err, r2.time))
