"""rospy's times, rates, sleeps and timers: the same program on stock's modules and on ours
(P26-P32)."""

from __future__ import annotations

import pytest
from faces import FACES, run, same
from harness import Master
from rospy_programs import TOOLS

HEAD = "import rospy\n" + TOOLS

MASTERS = ("ours",)

WALL = """
rospy.init_node("wall")
for bad in ("a", rospy.Time(0), None):
    t("sleep", lambda: rospy.sleep(bad))
t("rate", lambda: rospy.Rate(0))
r = rospy.Rate(10)
t("rate", lambda: (r.sleep_dur, type(r.last_time), type(r.remaining()), r.remaining().to_sec() <= 0.1, r.sleep()))
print(rospy.Rate(0.01).remaining().to_sec() > 50)
t("now", lambda: (type(rospy.Time.now()), type(rospy.get_rostime()), type(rospy.get_time())))
t("now", lambda: abs(rospy.get_time() - time.time()) < 5)
start = time.monotonic()
r = rospy.Rate(10)
for _ in range(10):
    r.sleep()
print(0.95 < time.monotonic() - start < 9)
def after_a_late_one():
    late = rospy.Rate(100)
    time.sleep(0.2)
    late.sleep()
    return late.remaining() > rospy.Duration(0)
until(after_a_late_one)  # on a busy machine 10 ms may be over at once
events = []
once = rospy.Timer(rospy.Duration(0.02), events.append, oneshot=True)
once.join(10)
t("once", lambda: (len(events), sorted(vars(events[0])), events[0].last_expected, events[0].last_real,
    events[0].last_duration))
t("once", lambda: (once.is_alive(), once.daemon, isinstance(once, threading.Thread), once.shutdown()))
often = rospy.Timer(period=rospy.Duration(0.01), callback=events.append)
until(lambda: len(events) > 5)
often.shutdown()
often.join(10)
e = events[-1]
t("often", lambda: (often.is_alive(), [type(v).__name__ for v in (e.last_expected, e.last_real, e.current_expected)]))
t("often", lambda: (str(e.current_expected - e.last_expected), e.current_real >= e.current_expected,
    type(e.last_duration)))
threading.excepthook = lambda args: print(args.exc_type.__name__, args.exc_value)
def bad(event):
    raise ValueError("in a timer")
failed = rospy.Timer(rospy.Duration(0.01), bad)
failed.join(10)
print(failed.is_alive())
t("constructors", lambda: (rospy.Time(1.5), rospy.Time(secs=1, nsecs=2), rospy.Time.from_sec(2.25),
    rospy.Time.from_seconds(3)))
t("constructors", lambda: (rospy.Duration(-0.5), rospy.Duration.from_sec(float_secs=0.25), rospy.Duration(1, -1)))
t("bad", lambda: rospy.Time(-1))
a, b = rospy.Time(3), rospy.Duration(2)
t("results", lambda: (a + b, b + a, a - b, str(a - a), b + b, b - b, b * 2, 2 * b, b / 2, -b, abs(-b),
    b * 0.5, b // b, b / b))
t("compare", lambda: (a > rospy.Time(2), b < rospy.Duration(3), a == b, a != b, bool(rospy.Duration(0)),
    hash(a) == hash(a)))
t("compare", lambda: a < b)
t("add", lambda: a + a)
import copy, pickle
t("copies", lambda: (pickle.loads(pickle.dumps(a)), copy.deepcopy(b),
    pickle.loads(pickle.dumps(String("x"))), copy.copy(Point(1, 2, 3))))
"""

SIMULATED = """
from rosgraph_msgs.msg import Clock
rospy.set_param("/use_sim_time", True)
rospy.init_node("sim")
rospy.delete_param("/use_sim_time")
clock = rospy.Publisher("/clock", Clock, queue_size=100)
t("zero", lambda: (rospy.Time.now(), rospy.get_time(), rospy.rostime.is_wallclock()))
until(lambda: clock.get_num_connections())
def tick(seconds):
    clock.publish(rospy.Time(seconds))
    until(lambda: rospy.get_time() == seconds)
def background(work):
    out = []
    def run():
        try:
            out.append(work())
        except rospy.ROSTimeMovedBackwardsException as error:
            out.append((type(error).__name__, isinstance(error, rospy.ROSInterruptException), str(error), error.time))
        except rospy.ROSInterruptException as error:
            out.append((type(error).__name__, str(error)))
    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    return thread, out
def move(thread, seconds, step):
    end = time.monotonic() + 20
    while thread.is_alive() and time.monotonic() < end:
        tick(seconds)
        seconds += step
        thread.join(0.05)
    return seconds
tick(10)
thread, out = background(lambda: rospy.sleep(5))
end = move(thread, 10.5, 0.5)
print(out, end >= 15)
rate = rospy.Rate(1)
thread, out = background(rate.sleep)
end = move(thread, end + 0.25, 0.25)
print(out)
events = []
timer = rospy.Timer(rospy.Duration(1), events.append)
thread, _ = background(lambda: until(lambda: len(events) >= 3))
end = move(thread, end + 0.25, 0.25)
print(len(events) >= 3, all(event.current_real >= event.current_expected for event in events))
timer.shutdown()
tick(200)
thread, out = background(lambda: rospy.sleep(1000))
until(lambda: asleep(thread))
tick(201)
tick(1)
thread.join(20)
print(out[0])
thread, out = background(lambda: rospy.sleep(1000))
until(lambda: asleep(thread))
rospy.signal_shutdown("end")
thread.join(10)
print(out)
t("after", lambda: rospy.sleep(1))
"""

JUMPS = (
    SIMULATED[: SIMULATED.index("tick(10)\n")]
    + """
tick(10)
rates = [rospy.Rate(8), rospy.Rate(8, reset=True)]
def show(rate):
    return round(rate.last_time.to_sec(), 3), round(rate.remaining().to_sec(), 3)
def jump(rate, seconds):
    thread, out = background(rate.sleep)
    until(lambda: asleep(thread) or not thread.is_alive())
    move(thread, seconds, 0)
    return show(rate), out
seconds = 10
for step in (0.125, 0.1875, 0.4375, 0.25, 100):
    seconds += step
    for rate in rates:
        print(step, jump(rate, seconds))
        while rate.remaining() <= rospy.Duration(0):  # these do not wait
            rate.sleep()
            print("again", show(rate))
for rate in rates:
    thread, out = background(rate.sleep)
    until(lambda: asleep(thread))
    tick(50)
    thread.join(20)
    print("back", rate.last_time == rospy.Time.now(), [each and each[:2] for each in out])
    tick(seconds)
"""
)

AGAIN = (
    SIMULATED[: SIMULATED.index("tick(10)\n")]
    + """
import itertools
tick(100)
for reset in (False, True):
    events = []
    timer = rospy.Timer(rospy.Duration(1), events.append, reset=reset)
    for first in (100, 20, 3):  # the bag is played again
        count = len(events) + 3
        thread, _ = background(lambda: until(lambda: len(events) >= count or not timer.is_alive()))
        move(thread, first, 0.25)
    times = itertools.groupby(event.current_real.secs // 10 for event in events)
    print(timer.is_alive(), [(time, len(list(group)) >= 3) for time, group in times])
    timer.shutdown()
"""
)

LAST_WORDS = (
    SIMULATED[: SIMULATED.index("tick(10)\n")]
    + """
tick(10)
def hook():
    for wait in (lambda: rospy.sleep(100), rospy.Rate(0.01).sleep):
        try:
            wait()
        except rospy.ROSInterruptException as error:
            print(rospy.is_shutdown(), type(error).__name__)
rospy.on_shutdown(hook)
rospy.signal_shutdown("the simulation has ended")
print(rospy.is_shutdown())
"""
)

SET = """
import genpy
from rosgraph_msgs.msg import Clock
rospy.set_param("/use_sim_time", True)
rospy.init_node("sim")
rospy.delete_param("/use_sim_time")
clock = rospy.Publisher("/clock", Clock, queue_size=100)
until(lambda: clock.get_num_connections())
def tick(seconds):
    clock.publish(rospy.Time(seconds))
    until(lambda: rospy.get_time() == seconds)
    print(rospy.Time.now(), rospy.rostime.is_wallclock())
tick(10)
for number in range(3):
    rospy.rostime._set_rostime(genpy.Time(50 + number))
    print(rospy.get_time(), rospy.rostime._rostime_current.secs)
    tick(11 + number)
rospy.rostime._rostime_current = rospy.Time(70)
print(rospy.get_time())
tick(20)
rospy.rostime._set_rostime(rospy.Time(80))
done = []
thread = threading.Thread(target=lambda: done.append(rospy.sleep(2)))
thread.start()
until(lambda: asleep(thread))
rospy.rostime._set_rostime(rospy.Time(81))
until(lambda: asleep(thread))
tick(82)
thread.join(20)
print(done, thread.is_alive(), rospy.rostime._rostime_current.secs)
"""
IGNORED = """
rospy.set_param("/use_sim_time", True)
rospy.init_node("ignores", disable_rostime=True)
rospy.delete_param("/use_sim_time")
print(rospy.rostime.is_wallclock())
"""


def test_wall_time(launcher: Master) -> None:
    assert "in a timer" in same(launcher, HEAD + WALL)


def test_simulated_time(launcher: Master) -> None:
    assert "ROS time moved backwards" in same(launcher, HEAD + SIMULATED)


def test_a_time_that_is_set_holds_until_the_next_message_on_clock(launcher: Master) -> None:
    assert "82" in same(launcher, HEAD + SET)


@pytest.mark.parametrize("face", FACES)
def test_simulated_time_is_ignored(launcher: Master, face: str) -> None:
    assert run(face, launcher, HEAD + IGNORED) == "True\n"


def test_rates_when_simulated_time_jumps(launcher: Master) -> None:
    same(launcher, HEAD + JUMPS)


def test_a_timer_goes_on_when_simulated_time_begins_again(launcher: Master) -> None:
    """As in the last release of Noetic; in the one of Debian a timer without ``reset`` ends."""
    lines = run("ours", launcher, HEAD + AGAIN).splitlines()[-2:]
    assert lines[1] == "True [(10, True), (2, True), (0, True)]"
    assert lines[0].startswith("True [(10, True), ")
    assert run("stock", launcher, HEAD + AGAIN).splitlines()[-1] == lines[1]


def test_hooks_do_not_wait_for_a_clock_that_has_gone(launcher: Master) -> None:
    """In stock the sleep, and so the end of the node, takes until somebody kills it."""
    text = run("ours", launcher, HEAD + LAST_WORDS)
    assert text.endswith("\n" + "False ROSInterruptException\n" * 2 + "True\n")
