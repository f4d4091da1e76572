"""rospy by pyros1 with many threads: what comes, goes and ends at the same time."""

from __future__ import annotations

import signal

import pytest
from programs import run

HEAD = """
import faulthandler, sys, threading, time, rospy
from std_msgs.msg import Float64
from std_srvs.srv import SetBool
faulthandler.dump_traceback_later(25, exit=True)
def until(reached):
    end = time.monotonic() + 15
    while not reached():
        assert time.monotonic() < end, "not in time"
        time.sleep(0.005)
"""

TOGETHER = """
results = []
def begin():
    rospy.init_node("together", disable_signals=True)
    results.append((rospy.get_name(), rospy.get_node_uri()))
threads = [threading.Thread(target=begin) for _ in range(8)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
assert len(results) == 8 and len(set(results)) == 1, results
rospy.wait_for_service("~get_loggers", 10)
assert not rospy.is_shutdown()
"""


def test_threads_that_start_the_node_together_get_one(environ: dict[str, str]) -> None:
    said = run(HEAD + TOGETHER, environ)
    assert said == ""


LOCKS = """
rospy.init_node("locks")
lock, inside, ask = threading.Lock(), threading.Event(), threading.Event()
def callback(message):
    inside.set()
    with lock:
        pass
publisher = rospy.Publisher("t", Float64, queue_size=1)
for _ in range(10):
    with lock:  # a program's own, for which its callback waits
        subscriber = rospy.Subscriber("t", Float64, callback)
        until(publisher.get_num_connections)
        publisher.publish(1)
        assert inside.wait(10)
        subscriber.unregister()
    inside.clear()
def work():
    ask.wait()
    rospy.signal_shutdown("the work is done")
worker = threading.Thread(target=work)
worker.start()
def hook():
    ask.set()
    worker.join()
    print("joined")
rospy.on_shutdown(hook)
rospy.signal_shutdown("enough")
print(rospy.is_shutdown())
"""


def test_locks_of_the_program_hold_up_nothing(environ: dict[str, str]) -> None:
    """Each of these waits once took as long as the deadline of the whole test, or longer."""
    assert run(HEAD + LOCKS, environ) == "joined\nTrue\n"


CHURN = """
sys.setswitchinterval(1e-6)
once, wrong = rospy.Publisher("once", Float64, latch=True, queue_size=1), []
early = [rospy.Subscriber("once", Float64, lambda _, i=i: early[i].unregister()) for i in range(20)]  # made too early
rospy.init_node("churn")
once.publish(1)
ended = threading.Event()
def attempt(number, action):
    while not ended.is_set():
        turns[number] += 1
        try:
            action()
        except rospy.ROSException as error:
            if "unregistered() handle" not in str(error):
                wrong.append(repr(error))
        except Exception as error:
            wrong.append(repr(error))
pubs = [rospy.Publisher("t", Float64, queue_size=1)] * 3
def change():
    pubs.append(rospy.Publisher("t", Float64, queue_size=1))
    pubs.pop(0).unregister()
def both():
    subscriber = rospy.Subscriber("t", Float64, lambda *_: None, [object()])
    threads = [threading.Thread(target=subscriber.unregister) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
def look():
    manager = rospy.topics.get_topic_manager()
    manager.get_pub_sub_stats(), manager.get_publications(), manager.get_pub_sub_info()
def of_all():
    impl = pubs[0].impl
    return impl and impl.get_num_connections()
actions = [lambda: pubs[0].publish(1.0)] * 2 + [change, both, look, of_all]
turns = [0] * len(actions)
threads = [threading.Thread(target=attempt, args=each) for each in enumerate(actions)]
for thread in threads:
    thread.start()
until(lambda: min(turns) > int(sys.argv[1]))
ended.set()
for thread in threads:
    thread.join(20)
assert not wrong, set(wrong)
until(lambda: all(subscriber.impl is None for subscriber in early))
manager = rospy.topics.get_topic_manager()
until(lambda: not [name for name in ("/once", "/t") if manager.get_subscriber_impl(name)])
_, _, (published, subscribed, _) = rospy.get_master().getSystemState()
assert "/once" not in [name for name, _ in subscribed] and "/t" not in [name for name, _ in subscribed], subscribed
"""


@pytest.mark.slow
def test_topics_that_come_and_go_in_many_threads(environ: dict[str, str]) -> None:
    run(HEAD + CHURN, environ, "25")


ENDING = """
sys.setswitchinterval(1e-5)
rospy.init_node("ending")
service = rospy.Service("s", SetBool, lambda request: (request.data, "ok"))
slow = rospy.Service("slow", SetBool, lambda request: (not rospy.rostime.wallsleep(0.02), "ok"))
publisher = rospy.Publisher("t", Float64, queue_size=1)
kept = rospy.ServiceProxy("s", SetBool, persistent=True)
rate = rospy.Rate(1000)
rospy.set_param("/cached", 1)
ended, wrong, left = threading.Event(), [], []
names = (f"own{number}" for number in range(1_000_000))
def later():
    return rospy.Service(next(names), SetBool, lambda request: (True, ""))
class Allowed(Exception):
    pass
of_services = (rospy.ServiceException, rospy.ROSInterruptException)
actions = [
    (of_services, lambda: rospy.ServiceProxy("s", SetBool)(True)),
    (of_services, lambda: rospy.ServiceProxy("slow", SetBool)(True)),
    (of_services, lambda: kept(True)),
    (rospy.ROSException, lambda: rospy.wait_for_message("none", Float64, 0.02)),
    (rospy.ROSInterruptException, lambda: rospy.wait_for_message("t", Float64)),
    (rospy.ROSException, lambda: rospy.wait_for_service("none", 0.02)),
    (Allowed, lambda: rospy.get_param("/none", 1)),
    (Allowed, lambda: rospy.get_param_cached("/cached")),
    (Allowed, lambda: rospy.set_param("/own", 1)),
    (Allowed, lambda: rospy.has_param("/own")),
    (Allowed, lambda: rospy.search_param("own")),
    (Allowed, rospy.get_param_names),
    (Allowed, rospy.get_published_topics),
    (Allowed, lambda: rospy.get_master().getSystemState()),
    (Allowed, lambda: publisher.publish(1.0)),
    (Allowed, lambda: rospy.Publisher("u", Float64, queue_size=1).unregister()),
    (Allowed, lambda: rospy.Subscriber("v", Float64, print).unregister()),
    (Allowed, lambda: later().shutdown()),
    (Allowed, lambda: rospy.sleep(0.001)),
    (Allowed, rate.sleep),
    (Allowed, lambda: rospy.logdebug("x")),
    (Allowed, lambda: rospy.Timer(rospy.Duration(0.0005), lambda _: None, oneshot=True).join(5)),
]
def loop(number, allowed, action):
    while not ended.is_set():
        turns[number] += 1
        try:
            action()
        except allowed:
            pass
        except BaseException as error:
            wrong.append(repr(error))
        if rospy.is_shutdown():
            time.sleep(0.002)  # some would never wait again, and leave the others no time
    left.append(None)
turns = [0] * len(actions)
threads = [threading.Thread(target=loop, args=(number, *each), daemon=True) for number, each in enumerate(actions)]
for thread in threads:
    thread.start()
until(lambda: rospy.has_param("/own"))
rospy.signal_shutdown("now")
before = list(turns)
until(lambda: all(now > then + 3 for now, then in zip(turns, before)))
ended.set()
for thread in threads:
    thread.join(15)
assert len(left) == len(actions) and not wrong, (len(left), set(wrong))
"""


@pytest.mark.slow
def test_the_end_of_the_node_under_all_kinds_of_waits(environ: dict[str, str]) -> None:
    run(HEAD + ENDING, environ)


SIGNALLED = """
import os, signal, sys, threading, rospy
from rospy.impl import rosout
def send():  # to this thread: another one may be late to take it
    signal.pthread_kill(threading.main_thread().ident, getattr(signal, sys.argv[1]))
configure = rosout.configure
def configure_later(level):  # there is no node yet
    send()
    return configure(level)
start = threading.Thread.start
def start_later(thread):
    if "reader" in thread.name and threading.current_thread() is threading.main_thread():
        send()
    start(thread)
if sys.argv[2] == "reader":
    threading.Thread.start = start_later
else:
    rosout.configure = configure_later
rospy.init_node("signalled")
from std_msgs.msg import String
rospy.Subscriber("x", String)
rospy.spin()
print("ended", rospy.is_shutdown())
"""


@pytest.mark.parametrize(("name", "number"), [("SIGINT", signal.SIGINT), ("SIGTERM", signal.SIGTERM)])
def test_a_signal_when_init_node_has_just_begun(environ: dict[str, str], name: str, number: int) -> None:
    assert "ended" not in run(SIGNALLED, environ, name, "node", code=-number)


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_signal_when_a_thread_of_the_node_is_about_to_start(environ: dict[str, str], name: str) -> None:
    assert run(SIGNALLED, environ, name, "reader") == "ended True\n"


ON_TOP = """
import itertools, random, signal
import diagnostic_updater, tf2_ros
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage
rospy.init_node("on_top", disable_signals=True)
names, left = itertools.count(), 300
buffer, static = tf2_ros.Buffer(), tf2_ros.StaticTransformBroadcaster()
updater = diagnostic_updater.Updater()
updater.setHardwareID("none")
updater.add("task", lambda status: (status.summary(0, "fine"), status)[1])
def work():
    transform = TransformStamped(child_frame_id="b")
    transform.header.frame_id, transform.header.stamp = "a", rospy.Time.now()
    transform.transform.rotation.w = 1
    buffer.set_transform(transform, "test")
    buffer.lookup_transform("a", "b", rospy.Time(0))
    buffer.can_transform("a", "b", rospy.Time(0))
    static.sendTransform(TransformStamped(child_frame_id=f"c{next(names) % 30}"))
    updater.force_update()
def arm():
    signal.setitimer(signal.ITIMER_REAL, random.uniform(100e-6, 1e-3))
def handle(*_):
    global left
    left -= 1
    if left >= 0:
        work()
        arm()
signal.signal(signal.SIGALRM, handle)
arm()
while left > 0 or next(names) < 30:
    work()
last = []
subscriber = rospy.Subscriber("/tf_static", TFMessage, last.append)
until(lambda: last and len(last[-1].transforms) == 30)
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no timers that send signals here")
def test_signal_handlers_do_what_they_interrupt(environ: dict[str, str]) -> None:
    """As programs do that save a pose, or send a last transform, when Ctrl-C ends them."""
    run(HEAD + ON_TOP, environ, timeout=40)


BURST = """
rospy.init_node("burst")
got, inside, gate = [], threading.Event(), threading.Event()
def callback(message):
    got.append(message.data)
    inside.set()
    gate.wait(15)
publisher = rospy.Publisher("t", Float64, queue_size=1)
subscriber = rospy.Subscriber("t", Float64, callback)
until(publisher.get_num_connections)
publisher.publish(0)
assert inside.wait(10)
for number in range(1, 201):  # which wait in stock's sockets
    publisher.publish(number)
gate.set()
until(lambda: got[-1] == 200)
assert got == list(range(201)), len(got)
"""


def test_a_burst_within_the_process_waits_for_a_slow_callback(environ: dict[str, str]) -> None:
    assert run(HEAD + BURST, environ) == ""
