"""rostopic's rates, sizes and ages of messages, at times that the program sets: on stock's modules and on ours."""

from __future__ import annotations

from faces import same
from harness import Master

MASTERS = ("ours",)

PROGRAM = """
import time
import rospy, rostopic
from geometry_msgs.msg import PointStamped
from std_msgs.msg import String
now = wall = 100.0
rospy.get_rostime = lambda: rospy.Time.from_sec(now)
time.time = lambda: wall
def attempt(ask, *arguments, **names):
    try:
        print("  ->", ask(*arguments, **names))
    except Exception as error:
        print("  raises", type(error).__name__)
def rates(*arguments, **names):
    made = rostopic.ROSTopicHz(*arguments, **names)
    print("rates", made.window_size, made.use_wtime, made.msg_t0, made.msg_tn, made.last_printed_tn, made.times)
    return made
one = rates(-1)
for ask in (one.get_hz, one.print_hz, one.get_times, one.get_msg_t0, one.get_msg_tn, one.get_last_printed_tn):
    attempt(ask)
for gap in (0, 0.125, 0.25, 0.5, 0.125):
    now += gap
    one.callback_hz("message")
attempt(one.get_hz)
attempt(one.print_hz)
now += 1
one.callback_hz("message")
attempt(one.print_hz)
attempt(one.print_hz)
for now in (50.0, 51.0, 0.0):
    one.callback_hz("message")
    attempt(one.get_hz)
    print(one.msg_t0, one.msg_tn, one.last_printed_tn, one.times)
several = rates(3)
for step in range(6):
    now = 200 + step * 0.25
    several.callback_hz("message", "/a")
    if step % 2:
        several.callback_hz("message", topic="/b")
for topics in (["/a"], ["/a"], ["/a", "/b"], ["/a", "/b"], [], ("/c",)):
    attempt(several.print_hz, topics)
now += 1.3
for topic in ("/a", "/b", "/a"):
    several.callback_hz("message", topic)
attempt(several.print_hz, topics=["/a", "/b", "/c"])
attempt(several.get_hz, "/c")
small = rates(9)
for step in range(5):
    now = 500 + step * 0.000123
    small.callback_hz("message", "/long/name/of/a/topic")
    now = 900 + step * 1234.5
    small.callback_hz("message", "/b")
attempt(small.print_hz, ["/b", "/long/name/of/a/topic"])
for name, value in (("last_printed_tn", 5), ("msg_t0", 6), ("msg_tn", 7), ("times", [1, 2])):
    for topic in (None, "/z"):
        attempt(getattr(small, "set_" + name), value, topic)
        attempt(getattr(small, "get_" + name), topic)
chosen = rates(5, lambda message: message == 1, True)
for message in (1, 2, 1, 1):
    wall += 0.5
    chosen.callback_hz(message)
attempt(chosen.get_hz)
at_once = rates(5)
for _ in range(3):
    at_once.callback_hz(1)
attempt(at_once.print_hz)
class Raw:
    def __init__(self, size):
        self._buff = b"x" * size
for window in (100, 2):
    sizes = rostopic.ROSTopicBandwidth(window)
    attempt(sizes.print_bw)
    for size in (10, 20, 2000, 1023, 999999, 3000000, 5):
        wall += 0.5
        sizes.callback(Raw(size))
        wall += 0.25
        sizes.print_bw()
    attempt(sizes.callback, String("no raw message"))
    print(sizes.sizes, sizes.window_size, rostopic.ROSTopicBandwidth().window_size)
def point(age):
    made = PointStamped()
    made.header.stamp = rospy.Time.from_sec(now - age)
    return made
for window in (-1, 3):
    now = 300.0
    ages = rostopic.ROSTopicDelay(window)
    print(ages.window_size, ages.delays, ages.msg_t0, ages.msg_tn, ages.last_msg_tn)
    attempt(ages.get_delay)
    attempt(ages.print_delay)
    attempt(ages.callback_delay, String())
    for age in (0.5, 0.125, 0.25, -0.5):
        now += 0.5
        ages.callback_delay(point(age))
        attempt(ages.print_delay)
        attempt(ages.get_delay)
    now += 1
    ages.callback_delay(point(1))
    attempt(ages.get_delay)
    for now in (10.0, 11.0, 0.0):
        ages.callback_delay(point(0))
        attempt(ages.get_delay)
"""


def test_rates_sizes_and_ages(master: Master) -> None:
    said = same(master, PROGRAM)
    assert "8.13e+03" in said and "MB/s" in said
