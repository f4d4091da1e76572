"""Beginnings of programs that look at the parts of actionlib; see interop/modules/test_actionlib_*_parts.py."""

BEGIN = """
import re, threading
import rospy, actionlib
from actionlib.msg import (TestAction, TestActionFeedback, TestActionGoal, TestActionResult, TestFeedback, TestGoal,
                           TestResult)
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
rospy.init_node("parts")
for name in ("logdebug", "loginfo", "logwarn", "logerr"):
    def log(text, *args, name=name):
        text = (text % args if args else text).split("Traceback")[0].split(" with destruction time")[0].strip()
        text = re.sub(r"1\\d{9}[.\\d]*", "NOW", re.sub(r"nsecs: *\\d+", "nsecs", text))
        print("   ", name, text.replace("_has_header", "PENDING"))  # a name of 0 in stock's classes
    setattr(rospy, name, log)
def attempt(function, *args, **names):
    try:
        result = function(*args, **names)
        print("   ->", str(result).replace("\\n", " ") if "object at" not in str(result) else type(result).__name__)
    except Exception as error:
        print("    raises", type(error).__name__, error)
def status(number, name="g"):
    return GoalStatus(goal_id=GoalID(id=name), status=number, text="text")
"""

TOPICS = """
class Topic:
    def __init__(self, name):
        self.name = name
    def publish(self, message):
        print("    publishes", self.name, message.header.stamp.is_zero(), end=" ")
        if self.name == "status":
            print([(each.goal_id.id, each.status, each.text[:14]) for each in message.status_list])
        else:
            part = message.result if self.name == "result" else message.feedback
            print(message.status.goal_id.id, message.status.status, message.status.text, str(part).strip())
    def unregister(self):
        print("    unregisters", self.name)
    shutdown = unregister
def with_topics(server):
    for name in ("status_pub", "result_pub", "feedback_pub", "goal_sub", "cancel_sub", "status_timer"):
        setattr(server, name, Topic(name.partition("_")[0] if "_pub" in name else name))
    server.started = True
    server.status_list_timeout = rospy.Duration(1000)
    return server
"""
