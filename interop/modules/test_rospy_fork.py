"""Processes that a rospy program forks, before its node starts and after: the same program on stock's modules and on ours."""

from __future__ import annotations

from faces import same
from harness import Master
from rospy_programs import TOOLS

HEAD = "import os, signal, threading, time\nimport rospy\n" + TOOLS

FORKED = """
def forked(label, call):
    reader, writer = os.pipe()
    child = os.fork()
    if not child:
        os.dup2(writer, 1)
        signal.alarm(30)  # a child that hangs is killed
        t(label, call)
        sys.stdout.flush()
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as said:
        print(said.read(), end="")
    print(label, os.waitpid(child, 0)[1])
    sys.stdout.flush()

def own(name):
    rospy.init_node(name, disable_signals=True)
    publisher = rospy.Publisher("own", String, queue_size=1, latch=True)
    publisher.publish(name)
    heard = rospy.wait_for_message("own", String, 10).data
    rospy.signal_shutdown("done")
    return heard

sys.stdout.flush()
forked("before", lambda: own("child_one"))
forked("before", lambda: own("child_two"))

heard = []
rospy.init_node("parent", ["p"])
publisher = rospy.Publisher("chat", String, queue_size=10, latch=True)
subscriber = rospy.Subscriber("chat", String, heard.append)
service = rospy.Service("serve", Trigger, lambda request: (True, "served"))
until(lambda: publisher.get_num_connections() == 1)
publisher.publish("first")
until(lambda: heard)
rospy.set_param("~x", 1)

forked("topics", lambda: ["/chat", "std_msgs/String"] in rospy.get_published_topics())
forked("names", lambda: (rospy.get_name(), rospy.resolve_name("~a"), rospy.is_shutdown()))
forked("publish", lambda: publisher.publish("from the child"))
forked("parameters", lambda: (rospy.get_param("~x"), rospy.set_param("~x", 2), rospy.get_param("~x")))
forked("cached", lambda: rospy.get_param_cached("~x"))
forked("another node", lambda: rospy.init_node("child", ["p"]))
forked("the same node", lambda: rospy.init_node("parent", ["p"]))
forked("message", lambda: rospy.wait_for_message("chat", String, 10).data)
forked("no message", lambda: rospy.wait_for_message("silent", String, 0.2))
forked("wait", lambda: rospy.wait_for_service("serve", 10))
forked("call", lambda: rospy.ServiceProxy("serve", Trigger)().message)
forked("time", lambda: (rospy.get_time() > 0, rospy.sleep(0.01), rospy.Rate(100).sleep()))

def timed():
    called = threading.Event()
    timer = rospy.Timer(rospy.Duration(0.01), lambda event: called.set())
    return called.wait(10)
forked("timer", timed)

publisher.publish("last")
until(lambda: heard[-1].data == "last")
t("parent", lambda: (rospy.get_param("~x"), rospy.ServiceProxy("serve", Trigger)().message, rospy.is_shutdown()))
"""


def test_forked_processes(master: Master) -> None:
    said = same(master, HEAD + FORKED)
    assert "message -> str 'first'" in said and "parent -> tuple (2, 'served', False)" in said
