"""rospy by pyros1: programs that need no stock ROS to compare with. What both do is compared in interop/modules."""

from __future__ import annotations

import os
import select
import signal
import threading
from typing import Any

import pytest
from programs import run, start

HEAD = """
import os, threading, time, rospy
from std_msgs.msg import Float64, Header, String
from geometry_msgs.msg import Point, PointStamped
from std_srvs.srv import SetBool, Trigger
def until(reached):
    end = time.monotonic() + 15
    while not reached():
        assert time.monotonic() < end, "not in time"
        time.sleep(0.005)
"""

TOPICS = """
early = rospy.Publisher("t", String, queue_size=10)  # before there is a node
got = []
s = rospy.Subscriber("t", String, lambda message, extra: got.append((message.data, extra)), "extra")
try:
    early.publish("x")
except rospy.ROSException as error:
    assert "init_node()" in str(error)
rospy.init_node("topics")
until(lambda: early.get_num_connections() == 1)
early.publish("one")
early.publish(data="two")
rospy.Publisher("t", String, latch=True, queue_size=5).publish(String("three"))
until(lambda: len(got) == 3)
assert got == [("one", "extra"), ("two", "extra"), ("three", "extra")], got
impl = early.impl
assert impl.ref_count == 2 and impl.is_latch and impl.has_connection("/topics")
assert impl.connections[0].stat_num_msg == 3
assert impl.get_stats_info()[0][1:3] == ("/topics", "o") and s.impl.get_stats()[1][0][2] == 3
assert rospy.topics.get_topic_manager().get_publisher_impl("/t") is impl
extra = []
s.impl.add_callback(lambda message, kind: extra.append((message.data, kind)), "added")
early.publish("four")
until(lambda: extra == [("four", "added")] and len(got) == 4)
for name, value in (("a", rospy.ROSException), ("b", TypeError)):
    try:
        early.publish(3 if name == "a" else Point())
        raise AssertionError(name)
    except value:
        pass
early.unregister()
try:
    early.publish("x")
    raise AssertionError
except rospy.ROSException as error:
    assert "unregistered" in str(error)
"""

WARNING = """
import warnings
rospy.init_node("warnings")
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("default")
    for _ in range(3):
        rospy.Publisher("w", String)
    rospy.Publisher("w", String, queue_size=1)
assert [(each.category, each.filename) for each in caught] == [(SyntaxWarning, "<string>")], caught
"""

SERVICES = """
for timeout in (0.05, -1, float("nan"), rospy.Duration(-1)):
    try:
        rospy.wait_for_service("none", timeout)
        raise AssertionError
    except rospy.ROSException as error:
        assert "timeout exceeded" in str(error)
for make in (rospy.Publisher, rospy.Subscriber):
    try:
        make("x", SetBool, queue_size=1)
        raise AssertionError
    except ValueError as error:
        assert "is not a message data class" in str(error)
rospy.init_node("services")
service = rospy.Service("s", SetBool, lambda request: {"success": request.data, "message": "told"})
proxy = rospy.ServiceProxy("s", SetBool, persistent=True, headers={"own": "field"})
assert [proxy(True).success, proxy(data=False).success, proxy.call(True).message] == [True, False, "told"]
bad = rospy.Service("bad", Trigger, lambda request: 1 / 0, error_handler=lambda *args: seen.append(args[1]))
seen = []
try:
    rospy.ServiceProxy("bad", Trigger)()
    raise AssertionError
except rospy.ServiceException as error:
    assert str(error) == "service [/bad] responded with an error: b'error processing request: division by zero'", error
assert seen == [ZeroDivisionError]
threading.Timer(0.05, service.shutdown).start()
service.spin()
"""

NAMES = """
import rospy.impl.udpros
"""

MISSING = """
for module, name in ((rospy, "nothing"), (rospy.impl, "udpros"), (rospy.names, "nothing"),
                     (rospy.topics, "QueuedConnection")):
    try:
        getattr(module, name)
        raise SystemError(name)
    except AttributeError as error:
        assert str(error).startswith(f"pyros1 has no {module.__name__}.{name}"), error
assert not hasattr(rospy.names, "__path__") and "loginfo" in dir(rospy.core) and rospy.core.rosgraph
try:
    import rospy.nothing
    raise SystemError
except ModuleNotFoundError:
    pass
"""

LOOP = """
rospy.init_node("loop")
p = rospy.Publisher("cmd_vel", Float64, queue_size=10)
def stop():
    p.publish(0)
    # print() raises RuntimeError in a signal handler that interrupts print().
    main = threading.current_thread() is threading.main_thread()
    os.write(1, f"stopped {main} {rospy.is_shutdown()}\\n".encode())
rospy.on_shutdown(stop)
until(lambda: p.get_num_connections())
print("ready", flush=True)
while not rospy.is_shutdown():
    p.publish(1)
"""

STUCK = """
rospy.init_node("stuck")
print("ready", flush=True)
try:
    while True:
        time.sleep(0.01)
except KeyboardInterrupt:
    print("interrupted", rospy.is_shutdown(), flush=True)
"""

THREADS = """
rospy.init_node("threads")
a, b = (rospy.Publisher(name, Float64, queue_size=10) for name in "ab")
met = threading.Barrier(2, timeout=10)
done = threading.Semaphore(0)
def meet(message):
    met.wait()
    done.release()
subscribers = [rospy.Subscriber(name, Float64, meet) for name in "ab"]
until(lambda: a.get_num_connections() and b.get_num_connections())
a.publish(1)
b.publish(1)
assert done.acquire(timeout=10) and done.acquire(timeout=10)
"""

CACHE = """
from rospy.impl.paramserver import get_param_server_cache
rospy.init_node("cache")
cache = get_param_server_cache()
rospy.set_param("~p", 1)
assert rospy.get_param_cached("~p") == 1 and cache.get("/cache/p") == 1
cache.update("/cache/p", 5)
assert rospy.get_param_cached("~p") == 5
cache.delete("/cache/p")
assert rospy.get_param_cached("~p") == 1
for wrong in (lambda: cache.get("/cache/q"), lambda: cache.delete("/cache/q"), lambda: cache.update("/cache/q", 1)):
    try:
        wrong()
        raise SystemError
    except KeyError:
        pass
"""

PLAIN = """
import copy, io, pickle
from rospy.msg import AnyMsg, deserialize_messages, serialize_message
m = PointStamped(Header(1, rospy.Time(2, 3), "f"), Point(1, 2, 3))
for other in (copy.deepcopy(m), copy.copy(m), pickle.loads(pickle.dumps(m))):
    assert other == m and str(other) == str(m)
b, out = io.BytesIO(), []
for seq in (7, 8):
    serialize_message(b, seq, m)
b.write(b"rest")
deserialize_messages(b, out, PointStamped)
assert [x.header.seq for x in out] == [7, 8] and b.getvalue() == b"rest", (out, b.getvalue())
assert repr(rospy.Time(1) + rospy.Duration(0.5)) == "rospy.Time[1500000000]"
assert repr(rospy.Duration(1) * 2) == "rospy.Duration[2000000000]"
"""


def test_topics(environ: dict[str, str]) -> None:
    run(HEAD + TOPICS, environ)


def test_warning_of_publishers_without_a_queue(environ: dict[str, str]) -> None:
    run(HEAD + WARNING, environ)


def test_services(environ: dict[str, str]) -> None:
    run(HEAD + SERVICES, environ)


def test_names_that_are_missing(environ: dict[str, str]) -> None:
    run(HEAD + MISSING, environ)
    assert "pyros1 has no rospy.impl.udpros" in run(HEAD + NAMES, environ, code=1)


def test_a_robot_stops_on_ctrl_c(environ: dict[str, str], make_node: Any) -> None:
    stopped = threading.Event()

    def drive(message: Any) -> None:
        if message.data:
            stopped.clear()
        else:
            stopped.set()

    make_node("motor").subscribe("cmd_vel", "std_msgs/Float64", drive)
    with start(HEAD + LOOP, environ) as child:
        assert child.stdout is not None and child.stdout.readline() == "ready\n"
        child.send_signal(signal.SIGINT)
        out, _ = child.communicate(timeout=20)
    assert out == "stopped True False\n" and child.returncode == 0
    assert stopped.wait(10)


def test_a_second_ctrl_c_interrupts_a_program_that_does_not_look(environ: dict[str, str]) -> None:
    with start(HEAD + STUCK, environ) as child:
        assert child.stdout is not None and child.stdout.readline() == "ready\n"
        try:
            for _ in range(100):  # signals within half a second count once
                child.send_signal(signal.SIGINT)
                if select.select([child.stdout], [], [], 0.6)[0]:
                    break  # it has been interrupted; another signal might interrupt its end
            out = child.communicate(timeout=10)[0]
        finally:
            child.kill()
    assert out == "interrupted True\n" and child.returncode == 0


FAILED = """
try:
    rospy.init_node("failed", tcpros_port=1 << 20)
except OverflowError:
    print("ready", flush=True)
for _ in range(3000):  # a signal just before a long sleep would wait for its end
    time.sleep(0.01)
"""


def test_ctrl_c_after_a_start_that_failed(environ: dict[str, str]) -> None:
    with start(HEAD + FAILED, environ) as child:
        assert child.stdout is not None and child.stdout.readline() == "ready\n"
        child.send_signal(signal.SIGINT)
        out, _ = child.communicate(timeout=20)
    assert "KeyboardInterrupt" in out and child.returncode == -signal.SIGINT


def test_callbacks_of_different_topics_run_at_once(environ: dict[str, str]) -> None:
    run(HEAD + THREADS, environ)


def test_copies_of_parameters(environ: dict[str, str]) -> None:
    run(HEAD + CACHE, environ)


def test_messages_and_times(environ: dict[str, str]) -> None:
    run(HEAD + PLAIN, environ)


FORKED = """
import multiprocessing, os, signal, rospy
from std_msgs.msg import String
def work(ready):
    ready.set()
    while not rospy.is_shutdown():
        rospy.rostime.wallsleep(0.01)
rospy.init_node("parent")
parent = os.getpid()
rospy.on_shutdown(lambda: print("hook of", "parent" if os.getpid() == parent else "child", flush=True))
publisher = rospy.Publisher("chatter", String, queue_size=10)
context = multiprocessing.get_context("fork")
for end in (lambda pid: os.kill(pid, signal.SIGINT), lambda pid: os.kill(pid, signal.SIGTERM)):
    ready = context.Event()
    child = context.Process(target=work, args=(ready,))
    child.start()
    ready.wait(10)
    end(child.pid)
    child.join(10)
    print("child:", child.exitcode, flush=True)
child = context.Process(target=rospy.signal_shutdown, args=("enough",))
child.start()
child.join(10)
print("child:", child.exitcode, flush=True)
assert not rospy.is_shutdown()
assert ["/chatter", ["/parent"]] in rospy.get_master().getSystemState()[2][0]
heard = []
rospy.Subscriber("chatter", String, heard.append)
publisher.publish("here")
while not heard:
    publisher.publish("here")
    rospy.sleep(0.01)
print("parent hears", heard[0].data, flush=True)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_the_end_of_a_forked_process_leaves_the_node_alone(environ: dict[str, str]) -> None:
    said = run(FORKED, environ)
    assert said.splitlines() == [
        *("hook of child", "child: 0", "hook of child", "child: -15", "hook of child", "child: 0"),
        *("parent hears here", "hook of parent"),
    ]
