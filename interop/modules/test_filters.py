"""message_filters: random sequences of messages through stock's filters and ours, with equal output."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from faces import run, same, start
from harness import Master

MASTERS = ("ours",)  # they do not ask it
pytestmark = pytest.mark.ours_only

PROGRAM = """
import random, sys
import rospy, message_filters
from std_msgs.msg import String
from sensor_msgs.msg import Joy

clock = [rospy.Time(100)]
rospy.Time.now = staticmethod(lambda: clock[0])
simulated = [False]
rospy.rostime.is_wallclock = lambda: not simulated[0]
rospy.logwarn = lambda *args: print("warn", *args)
rospy.loginfo = lambda *args: print("info", *args)
rospy.logdebug = lambda *args: print("debug", *args)

def show(*messages):
    print("set", *[(m.header.stamp.to_nsec(), m.header.seq) if hasattr(m, "header") else m.data for m in messages])

rng = random.Random(int(sys.argv[1]))
for case in range(60):
    count = rng.choice((1, 2, 2, 3, 4))
    kind, size = rng.choice(("exact", "near")), rng.choice((1, 2, 5, 10))
    simulated[0] = rng.random() < 0.5
    slop, free, reset = rng.choice((0, 0.002, 0.01, 0.1)), rng.random() < 0.3, rng.random() < 0.5
    inputs = [message_filters.SimpleFilter() for _ in range(count)]
    if kind == "exact":
        sync = message_filters.TimeSynchronizer(inputs, size, reset)
    else:
        sync = message_filters.ApproximateTimeSynchronizer(inputs, size, slop, free, reset=reset)
    sync.registerCallback(show)
    cache = message_filters.Cache(inputs[0], rng.choice((1, 3, 20)), allow_headerless=free)
    print("case", case, kind, count, size, slop, free, reset)
    for number in range(rng.choice((20, 100))):
        step = rng.choice((0, 0.001, 0.004, 0.05))
        if rng.random() < 0.03:
            clock[0] = clock[0] - rospy.Duration(min(5, clock[0].secs - 1))
        else:
            clock[0] = clock[0] + rospy.Duration(step)
        if kind == "near" and rng.random() < 0.1:
            message = String("free %d" % number)
        else:
            message = Joy()
            message.header.seq = number
            late = rospy.Duration(rng.choice((0, 0, 0.001, 0.003, 0.2)))
            message.header.stamp = clock[0] - late
        inputs[rng.randrange(count)].signalMessage(message)
        if rng.random() < 0.1:
            a, b = sorted((clock[0] - rospy.Duration(rng.random() / 5), clock[0] - rospy.Duration(rng.random() / 50)))
            print("cache", cache.getOldestTime(), cache.getLatestTime(), cache.getLastestTime())
            show(*cache.getInterval(a, b))
            show(*[each for each in (cache.getElemAfterTime(a), cache.getElemBeforeTime(b), cache.getLast()) if each])
    print([sorted(map(str, queue)) for queue in sync.queues])
"""


@pytest.mark.parametrize("seed", range(3))
def test_random_sequences(master: Master, seed: int) -> None:
    """Feature: filters: messages with equal or similar stamps, caches; equal to message_filters on random
    sequences -- `pyros1.filters`; `async for` over sets
    """
    printed = same(master, PROGRAM, str(seed))
    assert printed.count("set (") > 500


SIGNATURES = """
import inspect, message_filters
for name in ("SimpleFilter", "Subscriber", "Cache", "TimeSynchronizer", "ApproximateTimeSynchronizer"):
    cls = getattr(message_filters, name)
    for member in sorted(dir(cls)):
        value = getattr(cls, member)
        if inspect.isfunction(value) and (member[0] != "_" or member == "__init__"):
            parameters = inspect.signature(value).parameters.values()
            print(name, member, [(each.name, str(each.kind), each.default) for each in parameters])
"""


def test_signatures(master: Master) -> None:
    assert "slop" in same(master, SIGNATURES)


SYNCHRONIZED = """
import rospy, message_filters
from sensor_msgs.msg import CameraInfo, Image
rospy.init_node("synchronized")
inputs = [message_filters.Subscriber("image", Image), message_filters.Subscriber("info", CameraInfo, queue_size=10)]
print([each.getTopic() for each in inputs], [each.resolved_name for each in inputs])
got = []
def take(image, info, word):
    got.append((image.header.stamp == info.header.stamp, word))
    if len(got) == 3:
        print(got)
        rospy.signal_shutdown("enough")
message_filters.TimeSynchronizer(inputs, 10).registerCallback(take, "more")
image, info = rospy.Publisher("image", Image, queue_size=9), rospy.Publisher("info", CameraInfo, queue_size=9)
rate = rospy.Rate(50)
try:
    while not rospy.is_shutdown():
        one, other = Image(), CameraInfo()
        one.header.stamp = other.header.stamp = rospy.Time.now()
        image.publish(one)
        info.publish(other)
        rate.sleep()
except rospy.ROSInterruptException:
    pass
"""


def test_a_camera_and_its_info(master: Master) -> None:
    assert same(master, SYNCHRONIZED).count("(True, 'more')") == 3


PARTS = """
import rospy, message_filters
from message_filters import ApproximateTimeSynchronizer, Cache, SimpleFilter, Subscriber, TimeSynchronizer
from sensor_msgs.msg import Joy
rospy.Time.now = staticmethod(lambda: rospy.Time(50))
def joy(seconds):
    message = Joy()
    message.header.stamp = rospy.Time.from_sec(seconds)
    return message
def show(*what):
    print([each.header.stamp.to_sec() if isinstance(each, Joy) else each for each in what])

class Own(ApproximateTimeSynchronizer):
    # as programs do that need another rule
    def add(self, msg, my_queue, my_queue_index=None):
        self.lock.acquire()
        my_queue[msg.header.stamp] = msg
        while len(my_queue) > self.queue_size:
            del my_queue[min(my_queue)]
        print(my_queue_index, [len(each) for each in self.queues], self.slop.to_sec(), self.queues[0] is my_queue)
        if all(self.queues):
            self.signalMessage(*[each[max(each)] for each in self.queues])
        self.lock.release()

inputs = [SimpleFilter(), SimpleFilter()]
own = Own(inputs, 2, 0.5)
print(own.registerCallback(show, "more"), own.registerCallback(show), sorted(own.callbacks))
for number in range(4):
    inputs[number % 2].signalMessage(joy(number))
for cls, options in ((TimeSynchronizer, {}), (ApproximateTimeSynchronizer, {"slop": 0.1})):
    sync = cls([], 10, **options)
    sync.registerCallback(show)
    sync.connectInput(inputs)
    print(len(sync.queues), len(sync.input_connections), [each.to_sec() for each in sync.latest_stamps])
    sync.add(joy(7), sync.queues[0])
    sync.add(joy(8), sync.queues[0], 0)
    sync.add(joy(7), sync.queues[1])
    inputs[1].signalMessage(joy(8))
    sync.queue_size = 1
    sync.add(joy(9), sync.queues[0], 0)
    sync.add(joy(10), sync.queues[0], 0)
    sync.add(joy(9), sync.queues[1], 1)
    print([sorted(each.to_sec() for each in queue) for queue in sync.queues])
cache = Cache(inputs[0], cache_size=2)
cache.registerCallback(show, "cached")
cache.add(joy(3))
cache.connectInput(inputs[1])
for each in (inputs[1], inputs[0]):
    each.signalMessage(joy(4))
show(*cache.cache_msgs)
print([each.to_sec() for each in cache.cache_times], cache.allow_headerless)
try:
    cache.getInterval(rospy.Time(5), rospy.Time(4))
except AssertionError:
    print("AssertionError")
subscriber = Subscriber("/somewhere", Joy, queue_size=3)
subscriber.registerCallback(show, 1)
subscriber.callback(joy(5))
print(subscriber.getTopic(), subscriber.name, subscriber.get_num_connections(), subscriber.data_class is Joy)
try:
    subscriber.nothing
except AttributeError:
    print("AttributeError")
"""


def test_parts_that_programs_use(master: Master) -> None:
    assert "AttributeError" in same(master, PARTS)


CLOCK = """
import rospy
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64
rospy.init_node("clock", disable_rostime=True)
now = [10.0]
publisher = rospy.Publisher("/clock", Clock, queue_size=1, latch=True)
def jump(message):
    now[0] = message.data
    publisher.publish(Clock(rospy.Time.from_sec(now[0])))
jump(Float64(10))
subscriber = rospy.Subscriber("jump", Float64, jump)
print("ready", flush=True)
rospy.spin()
"""
SIMULATED = """
import rospy, message_filters
from sensor_msgs.msg import Joy
from std_msgs.msg import Float64
rospy.init_node("simulated", anonymous=True)
rospy.loginfo = lambda *args: print("info", *args)
jumps = rospy.Publisher("jump", Float64, queue_size=1)
def wait(condition):
    while not condition():
        rospy.rostime.wallsleep(0.01)
wait(jumps.get_num_connections)
def jump(seconds):
    jumps.publish(seconds)
    wait(lambda: rospy.get_time() == seconds)
def joy(seconds):
    message = Joy()
    message.header.stamp = rospy.Time.from_sec(seconds)
    return message
print(rospy.rostime.is_wallclock())
for cls, options in (
    (message_filters.TimeSynchronizer, {}),
    (message_filters.TimeSynchronizer, {"reset": True}),
    (message_filters.ApproximateTimeSynchronizer, {"slop": 0.1}),
    (message_filters.ApproximateTimeSynchronizer, {"slop": 0.1, "reset": True}),
):
    jump(20.0)
    inputs = [message_filters.SimpleFilter(), message_filters.SimpleFilter()]
    sync = cls(inputs, 5, **options)
    sync.registerCallback(lambda *found: print([each.header.stamp.secs for each in found]))
    for index, seconds in ((0, 19), (1, 19), (0, 20)):
        inputs[index].signalMessage(joy(seconds))
    jump(5.0)
    for index, seconds in ((1, 20), (0, 5), (1, 5), (0, 20)):
        inputs[index].signalMessage(joy(seconds))
    jump(6.0)
    for index, seconds in ((0, 6), (1, 6)):
        inputs[index].signalMessage(joy(seconds))
    print([len(each) for each in sync.queues])
"""


def test_jumps_of_simulated_time(own_master: Callable[[str], Master]) -> None:
    master = own_master("ours")
    master.start()
    run("ours", master, "import rospy; rospy.set_param('/use_sim_time', True)")
    start("ours", master, CLOCK).wait_line("^ready$")
    assert same(master, SIMULATED).startswith("False\n")
