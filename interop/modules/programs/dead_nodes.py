"""rosnode's dead nodes, rosunit's and rostest's runners, rosbag's tuples."""

import contextlib
import io
import os
import re
import socket
import sys
import tempfile
import time
import unittest
import genpy
import rosbag
import rosbag.bag
import rosgraph
import rosnode
import rospy
import rostest
import rosunit
from rosunit import junitxml
import rosunit.pyunit

os.chdir(tempfile.mkdtemp(dir=os.environ["HOME"]))


def t(title, call, *arguments, **named):
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            found = repr(call(*arguments, **named))
        except SystemExit as error:
            found = f"exit {error.code}"
        except Exception as error:
            found = f"{type(error).__name__}: {error}"
    text = re.sub(r" at 0x[0-9a-f]+", "", found + "\n" + out.getvalue() + "##" + err.getvalue())
    print(
        title,
        re.sub(r"[0-9]+\.[0-9]+", "N", re.sub(r":[0-9]{2,}", ":PORT", text)).replace(os.getcwd(), "HERE").split("\n"),
        flush=True,
    )


# dead nodes
def free():
    with socket.socket() as s:
        s.bind(("localhost", 0))
        return s.getsockname()[1]


import xmlrpc.client

raw = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])


def dead():
    uri = "http://localhost:%d/" % free()
    raw.registerPublisher("/dead_node", "/dead_topic", "std_msgs/String", uri)
    raw.registerSubscriber("/dead_node", "/dead_sub", "std_msgs/String", uri)
    raw.registerService("/dead_node", "/dead_srv", "rosrpc://localhost:%d" % free(), uri)


def state():
    s = raw.getSystemState("/me")[2]
    return [sorted(e[0] for e in p if "/dead_node" in e[1]) for p in s]


dead()
print(state())
for answer in ("n\n", "y\n"):
    r, w = os.pipe()
    f = os.fdopen(w, "w")
    f.write(answer)
    f.close()
    sys.stdin = os.fdopen(r)
    t("cleanup", rosnode.rosnode_cleanup)
    print(state())
dead()
t("ping", rosnode.rosnode_ping, "/dead_node", 1)
t("master", lambda: [len(x) for x in rosnode.rosnode_ping_all()][1] >= 0)
m = rosgraph.Master("/rosnode")
t("cl", rosnode.cleanup_master_blacklist, m, ["/dead_node"])
print(state())
dead()
t("cl", rosnode.cleanup_master_whitelist, m, [n for n in rosnode.get_node_names() if n != "/dead_node"])
print(state())
t("none", rosnode.rosnode_cleanup)
t("debug", rosnode.rosnode_debugnode, "/not_there")
t("info", rosnode.rosnode_info, "/not_there", True)
dead()
t("info", rosnode.rosnode_info, "/dead_node")
t("info", rosnode.rosnode_info, "/dead_node", quiet=True)
t("debug", rosnode.rosnode_debugnode, "/dead_node")
m and rosnode.cleanup_master_blacklist(m, ["/dead_node"])
# bags
for n in ("BagMessage", "BagMessageWithConnectionHeader"):
    c = getattr(rosbag.bag, n)
    print(n, c._fields)
    t("make", lambda: c(*range(len(c._fields))))
    t("few", c, 1)
with rosbag.Bag("x.bag", "w") as b:
    from std_msgs.msg import String

    b.write("/a", String("x"), genpy.Time(5))
with rosbag.Bag("x.bag") as b:
    a = list(b.read_messages())[0]
    t("a", lambda: (isinstance(a, rosbag.bag.BagMessage), type(a).__name__, a.topic, a[2]))
    a = list(b.read_messages(return_connection_header=True))[0]
    t(
        "a",
        lambda: (
            isinstance(a, rosbag.bag.BagMessageWithConnectionHeader),
            type(a).__name__,
            a.topic,
            sorted(a.connection_header),
            sorted(a[3]),
        ),
    )


# rosunit
class Tests(unittest.TestCase):
    def test_good(self):
        pass

    def test_bad(self):
        self.fail("bad")

    def test_error(self):
        raise ValueError("error")

    @unittest.skip("why")
    def test_skipped(self):
        pass


suite = lambda: unittest.TestLoader().loadTestsFromTestCase(Tests)
os.environ["ROS_TEST_RESULTS_DIR"] = os.path.join(os.getcwd(), "results")
runner = None


def make(*a, **k):
    global runner
    runner = rosunit.create_xml_runner(*a, **k)
    return type(runner).__name__


t("runner", make, "pkg", "name", os.path.join(os.getcwd(), "out.xml"))
result = None


def run():
    global result
    result = runner.run(suite())
    return (result.testsRun if hasattr(result, "testsRun") else result.num_tests, result.wasSuccessful())


with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
    found = run()
print(found)
text = open("out.xml").read() if os.path.exists("out.xml") else sorted(os.listdir("."))
import xml.etree.ElementTree as ET

e = ET.fromstring(text)
print(
    e.tag,
    sorted((k, v) for k, v in e.attrib.items() if k != "time"),
    [(c.tag, sorted((k, v) for k, v in c.attrib.items() if k != "time"), [d.tag for d in c]) for c in e],
)
t("default file", make, "pkg2", "name2")
t("is_rostest", make, "pkg2", "name3", is_rostest=True)
print(sorted(os.path.relpath(os.path.join(d, f)) for d, _, fs in os.walk(".") for f in fs if f.endswith(".xml")))
r = unittest.TestResult()
suite().run(r)
t("unittest summary", rosunit.print_unittest_summary, r)
r2 = unittest.TestResult()
t("empty", rosunit.print_unittest_summary, r2)
j = junitxml.Result("j", 1, 2, 7)
c = junitxml.TestCaseResult("case1")
c.add_failure(junitxml.TestFailure("F", "why"))
j.add_test_case_result(c)
j.add_test_case_result(junitxml.TestCaseResult("case2"))
t("runner summary", rosunit.print_runner_summary, r, j)
t("named", rosunit.print_runner_summary, r2, j, "MINE")
t("named", rosunit.print_runner_summary, r2, junitxml.Result("e"), runner_name="E")
t("junit", junitxml.print_summary, j)
t("junit", junitxml.print_summary, j, "X")
sys.argv = ["rostest", "--no-such-option"]
with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
    try:
        rostest.rostestmain()
    except SystemExit as error:
        code = error.code
print(code)
