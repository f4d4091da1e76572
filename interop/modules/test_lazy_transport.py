"""topic_tools.LazyTransport on stock's modules and on ours."""

from __future__ import annotations

import pytest
from faces import same
from harness import Master

MASTERS = ("ours",)  # they do not ask it
pytestmark = pytest.mark.ours_only

PROGRAM = """
import rospy
from std_msgs.msg import String
from topic_tools import LazyTransport

class Echo(LazyTransport):
    def __init__(self, *names):
        super(Echo, self).__init__()
        self.log = []
        self.out = [self.advertise(name, String, queue_size=1) for name in names]
        self.into = rospy.resolve_name("~in")
    def subscribe(self):
        self.log.append("subscribe")
        self.sub = rospy.Subscriber(self.into, String, lambda word: [each.publish(word) for each in self.out])
    def unsubscribe(self):
        self.log.append("unsubscribe")
        self.sub.unregister()

def until(condition):
    while not condition():
        rospy.sleep(0.01)

rospy.init_node("echo", anonymous=True)
words = rospy.Publisher("~in", String, queue_size=1, latch=True)
words.publish("hello")
for lazy in (True, False):
    rospy.set_param("~lazy", lazy)
    a, b = "~a%d" % lazy, "~b%d" % lazy
    echo = Echo(a, b)
    print(lazy, [each.resolved_name[-2:] for each in echo.out], echo.log)
    heard = []
    first = rospy.Subscriber(a, String, heard.append)
    until(lambda: heard)
    second = rospy.Subscriber(b, String)
    until(lambda: echo.out[1].get_num_connections())
    print(heard[0].data, echo.log)
    first.unregister()
    until(lambda: not echo.out[0].get_num_connections())
    print(echo.log)
    second.unregister()
    until(lambda: not echo.out[1].get_num_connections())
    if lazy:
        until(lambda: len(echo.log) == 2)
    print(echo.log)
try:
    echo.advertise("~c", String, queue_size=1, subscriber_listener=rospy.SubscribeListener())
except AssertionError:
    print("AssertionError")
try:
    LazyTransport().subscribe()
except NotImplementedError as error:
    print(error)
rospy.delete_param("~")
"""


def test_lazy_transport(master: Master) -> None:
    assert "unsubscribe" in same(master, PROGRAM)
