"""The end of rospy's node: the same program on stock's modules and on ours (P03-P05).

Feature: rospy's signals, shutdown hooks and exits -- a robot stops before its node exits
"""

from __future__ import annotations

import contextlib
import signal

import pytest
from faces import FACES, same, start
from harness import Master
from rospy_programs import TOOLS

HEAD = "import rospy\n" + TOOLS

MASTERS = ("ours",)

HOOKS = """
rospy.init_node("ends")
p = rospy.Publisher("x", String, queue_size=1)
service = rospy.Service("own", Empty, lambda request: [])
def first():
    print("first", rospy.is_shutdown(), rospy.core.is_shutdown_requested(), rospy.core._in_shutdown)
    t("works", lambda: (rospy.sleep(0.05), p.publish("x"), rospy.get_param("/nope", 1)))
    t("works", lambda: rospy.ServiceProxy("own", Empty)())
def broken():
    raise ValueError("in a hook")
rospy.on_shutdown(first)
rospy.on_shutdown(broken)
rospy.core.add_preshutdown_hook(lambda reason: print("before", reason, rospy.is_shutdown()))
rospy.core.add_shutdown_hook(lambda reason: print("after", reason, rospy.is_shutdown()))
rospy.core.add_client_shutdown_hook(lambda: print("second"))
rospy.signal_shutdown("the reason")
print(rospy.is_shutdown(), rospy.core.is_shutdown_requested())
rospy.on_shutdown(lambda: print("late"))
t("publish", lambda: p.publish("x"))
start = time.monotonic()
t("sleep", lambda: rospy.sleep(0.05))
t("rate", lambda: rospy.Rate(20).sleep())
print(time.monotonic() - start > 0.09)
t("wait", lambda: rospy.wait_for_message("x", String))
t("wait", lambda: rospy.wait_for_service("own"))
t("call", lambda: rospy.ServiceProxy("own", Empty)())
t("new", lambda: rospy.Publisher("y", String, queue_size=1).get_num_connections())
t("new", lambda: rospy.Subscriber("y", String).get_num_connections())
t("spin", rospy.spin)
t("param", lambda: rospy.get_param("/nope", 3))
t("init", lambda: rospy.init_node("ends"))
t("unregister", lambda: p.unregister())
t("again", lambda: rospy.signal_shutdown("again"))
"""

NO_NODE = """
rospy.on_shutdown(lambda: print("hook"))
rospy.signal_shutdown("none")
print(rospy.is_shutdown(), rospy.core.is_shutdown_requested())
"""

LOOP = """
rospy.init_node("loop")
p = rospy.Publisher("x", String, queue_size=1)
where = []
def hook():
    print("hook", threading.current_thread() is threading.main_thread(), rospy.is_shutdown(), flush=True)
    rospy.sleep(0.1)
rospy.on_shutdown(hook)
rate = rospy.Rate(50)
print("ready", flush=True)
if "spin" in sys.argv:
    rospy.spin()
elif "long" in sys.argv:
    rospy.sleep(2)
else:
    while not rospy.is_shutdown():
        p.publish("x")
        rate.sleep()
print("over", rospy.is_shutdown(), flush=True)
"""

INTERRUPTED = """
rospy.init_node("interrupted", disable_signals=True)
rospy.on_shutdown(lambda: print("hook", rospy.is_shutdown()))
def spinning():
    frame = sys._current_frames()[threading.main_thread().ident]
    while frame is not None and frame.f_code.co_name != "spin":
        frame = frame.f_back
    return frame is not None
def interrupt():
    until(spinning)
    os.kill(os.getpid(), 2)
threading.Thread(target=interrupt).start()
rospy.spin()
print("over", rospy.is_shutdown())
"""

CHAIN = """
def own(number, frame):
    print("own handler", number, flush=True)
signal = __import__("signal")
signal.signal(signal.SIGINT, own)
rospy.init_node("chain")
print("ready", flush=True)
rospy.spin()
print("over", flush=True)
"""

THREAD = """
def work():
    t("init", lambda: rospy.init_node("thread"))
thread = threading.Thread(target=work)
thread.start()
thread.join()
print(rospy.get_name())
"""

DISABLED = """
thread = threading.Thread(target=lambda: rospy.init_node("thread", disable_signals=True))
thread.start()
thread.join()
print(rospy.get_name())
"""

EXIT = """
rospy.init_node("exits")
rospy.on_shutdown(lambda: print("hook", rospy.is_shutdown()))
print("end of the program")
"""


def test_hooks(launcher: Master) -> None:
    assert "late" in same(launcher, HEAD + HOOKS)


def test_shutdown_without_a_node(launcher: Master) -> None:
    assert same(launcher, HEAD + NO_NODE) == "hook\nTrue True\n"


def test_end_of_the_program(launcher: Master) -> None:
    assert same(launcher, HEAD + EXIT) == "end of the program\nhook False\n"


def test_not_in_the_main_thread(launcher: Master) -> None:
    assert "main thread" in same(launcher, HEAD + THREAD)
    assert same(launcher, HEAD + DISABLED) == "/thread\n"


@pytest.mark.parametrize("face", FACES)
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("way", ["loop", "spin", "long"])
def test_signals(launcher: Master, face: str, number: int, way: str) -> None:
    program = start(face, launcher, HEAD + LOOP, way)
    program.wait_line("ready")
    program.signal(number)
    program.wait_line("hook True False")
    program.wait_line("over True")
    assert program.wait() == 0


def test_spin_without_signal_handlers(launcher: Master) -> None:
    assert same(launcher, HEAD + INTERRUPTED) == "hook False\nover True\n"


@pytest.mark.parametrize("face", FACES)
def test_former_handler(launcher: Master, face: str) -> None:
    program = start(face, launcher, HEAD + CHAIN)
    program.wait_line("ready")
    program.signal(signal.SIGINT)
    program.wait_line("own handler 2")
    program.wait_line("over")
    assert program.wait() == 0


@pytest.mark.parametrize("face", FACES)
def test_shutdown_by_the_api(launcher: Master, face: str) -> None:
    program = start(face, launcher, HEAD + LOOP, "loop")
    program.wait_line("ready")
    with contextlib.suppress(OSError):  # stock may end before it answers
        launcher.node("/loop", "shutdown", "asked for")
    program.wait_line("hook False False")
    program.wait_line("over True")
    assert program.wait() == 0
