"""rostopic.msgevalgen, for random paths to fields: their values. How a missing field is reported is not compared."""

import contextlib
import io
import random

import rostopic
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Pose, PoseArray
from sensor_msgs.msg import Image, JointState
from std_msgs.msg import String

poses = PoseArray(poses=[Pose(), Pose(), Pose()])
for number, pose in enumerate(poses.poses):
    pose.position.y = number
status = DiagnosticStatus(name="x", values=[KeyValue("k", "v"), KeyValue("l", "w")])
MESSAGES = [
    poses,
    JointState(name=["a", "b"], position=[1.0, 2.0]),
    DiagnosticArray(status=[status, status]),
    Image(data=b"abc"),
    String("hello"),
]
NAMES = "poses position y name header stamp secs nsecs frame_id status values key data nope seq orientation".split()
SUBSCRIPTS = ["", "", "", "", "[0]", "[1]", "[-1]", "[9]", "[:]", "[1:]", "[::-1]", "[:2:1]", "[0:1]", "[", "[x]"]
dice = random.Random(4)


def found(path, message):
    """Return the value as text; None if there is no such field."""
    try:
        value = rostopic.msgevalgen(path)(message)
    except (AttributeError, TypeError, ValueError):
        return None
    text = repr(value)
    return None if "None" in text else text


for _ in range(4000):
    path = "/".join(dice.choice(NAMES) + dice.choice(SUBSCRIPTS) for _ in range(dice.randrange(5)))
    path = dice.choice(["/", ""]) + path + dice.choice(["", "/"])
    with contextlib.redirect_stderr(io.StringIO()):
        values = [found(path, message) for message in MESSAGES]
    print(path, values)
