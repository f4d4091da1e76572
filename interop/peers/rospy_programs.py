"""What the programs of the tests of rospy begin with, after ``import rospy``.

``t(label, function)`` prints what a call returns or raises. ``asleep(thread)`` says whether a thread waits in a sleep
in simulated time: it has read the time at which it began.
"""

TOOLS = """
import logging, os, sys, threading, time, warnings
warnings.simplefilter("ignore")
from std_msgs.msg import Float64, Header, Int32, String
from geometry_msgs.msg import Point, PointStamped
from std_srvs.srv import Empty, EmptyRequest, EmptyResponse, SetBool, SetBoolResponse, Trigger
KINDS = ("ROS", "Ser", "Val", "Typ", "Key", "Att")
def t(label, call):
    try:
        value = call()
        print(label, "->", type(value).__name__, repr(value))
    except BaseException as error:
        kind = type(error)
        print(label, "!!", [each.__name__ for each in kind.__mro__ if each.__name__[:3] in KINDS], error)
def asleep(thread):
    frame, names = sys._current_frames().get(thread.ident), []
    while frame is not None:
        names.append(frame.f_code.co_name)
        frame = frame.f_back
    return "sleep" in names and names[0] in ("wait", "wait_for", "_acquire_in_steps")
def until(reached, seconds=30):
    end = time.monotonic() + seconds
    while not reached():
        assert time.monotonic() < end, "not in time"
        time.sleep(0.01)
"""
