"""tf2_py.BufferCore of stock (C++) and ours: one program, the same random trees and questions, the same answers."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
from faces import command, environ, same
from harness import Master
from tf_cases import STRANGE, random_case, settle
from tf_questions import Question
from tf_questions import same as close

MASTERS = ("ours",)  # these programs need no master; the fixture gives their environment
PROGRAM = Path(__file__).resolve().parents[1] / "peers" / "tf_stock.py"


def ask(face: str, master: Master, questions: list[Question]) -> list[Any]:
    """Return the answers of a face."""
    done = subprocess.run(
        command(face, PROGRAM),
        input=json.dumps(questions),
        env=environ(face, master),
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, f"{face}: {done.stderr[-3000:]}"
    text = done.stdout.replace("is in the buffe,", "is in the buffer,")  # stock cuts off what is longer than its array
    answers: list[Any] = json.loads(text)
    return answers


def compare(master: Master, questions: list[Question]) -> list[Any]:
    ours, stock = ask("ours", master, questions), ask("stock", master, questions)
    for question, mine, other in zip(questions, ours, stock, strict=True):
        settle(mine, other)
        assert close(mine, other), f"{question}\nours:  {mine}\nstock: {other}"
    return ours


@pytest.mark.parametrize("seed", range(4))
def test_random_trees_times_and_time_travel(master: Master, seed: int) -> None:
    questions = [question for number in range(40) for question in random_case(5000 + 1000 * seed + number)]
    kinds = {answer[0] for answer in compare(master, questions)}
    wanted = {"LookupException", "ConnectivityException", "ExtrapolationException", "InvalidArgumentException"}
    assert wanted | {"lookup", "full", "common"} <= kinds, "the cases must reach all ends"


def test_strange_input(master: Master) -> None:
    compare(master, STRANGE)


ARGUMENTS = """
import rospy, tf2_py
from geometry_msgs.msg import TransformStamped

def say(label, ask, *arguments, **named):
    try:
        print(label, ask(*arguments, **named))
    except Exception as error:
        wrong = isinstance(error, TypeError)
        print(label, type(error).__name__, *[] if wrong else [error])

def stamped(parent, child, seconds):
    message = TransformStamped()
    message.header.frame_id, message.child_frame_id, message.header.stamp = parent, child, rospy.Time(seconds)
    message.transform.rotation.w = 1.0
    return message

def described(message):
    return (message.header.frame_id, message.child_frame_id, message.header.seq, str(message.header.stamp),
            type(message.header.stamp).__name__, message.transform.translation.x, type(message).__name__)

for cache in (None, 10, 1.5, "x", rospy.Duration(3)):
    try:
        tf2_py.BufferCore(cache)
        print("made")
    except TypeError as error:
        print(error)
say("empty string", tf2_py.BufferCore().all_frames_as_string)
say("empty yaml", tf2_py.BufferCore().all_frames_as_yaml)
say("empty dot", tf2_py.BufferCore()._allFramesAsDot)
say("empty dot", tf2_py.BufferCore()._allFramesAsDot, rospy.Time(3))
core = tf2_py.BufferCore(cache_time=rospy.Duration(10))
say("one", core.set_transform, stamped("a", "b", 1))
say("named", core.set_transform, transform=stamped("a", "b", 1), authority="me")
for seconds in (1, 2):
    core.set_transform(stamped("a", "b", seconds), "me")
core.set_transform_static(stamped("b", "c", 0), "you")
core.set_transform(stamped("/b", "/d", 2), "me")
zero, two = rospy.Time(0), rospy.Time(2)
print(described(core.lookup_transform_core("a", "c", zero)))
print(described(core.lookup_transform_core(target_frame="a", source_frame="c", time=rospy.Time(1, 500000000))))
print(described(core.lookup_transform_full_core("a", zero, "c", zero, "b")))
named = {"target_frame": "a", "target_time": zero, "source_frame": "c", "source_time": two, "fixed_frame": "a"}
print(described(core.lookup_transform_full_core(**named)))
say("can full", core.can_transform_full_core, **named)
say("chain", core._chain, **named)
say("chain", core._chain, "c", zero, "a", zero, "b")
say("can", core.can_transform_core, "a", "c", zero)
say("can", core.can_transform_core, target_frame="a", source_frame="c", time=two)
say("can", core.can_transform_core, "a", "c", rospy.Duration(2))
for time in (0, 0.0, None, "x"):
    say("time", core.can_transform_core, "a", "c", time)
    say("time", core.lookup_transform_core, "a", "c", time)
say("few", core.can_transform_core, "a", "c")
say("few", core.lookup_transform_core, "a", "c")
say("many", core.lookup_transform_core, "a", "c", zero, 1)
say("few", core.lookup_transform_full_core, "a")
say("bytes", core.can_transform_core, b"a", "c", zero)
say("None", core.can_transform_core, None, "c", zero)
say("common", core.get_latest_common_time, "a", "c")
say("common", core.get_latest_common_time, "b", "c")
say("common", core.get_latest_common_time, "b", "nope")
say("common", core.get_latest_common_time, "/b", "c")
say("string", core.all_frames_as_string)
say("yaml", core.all_frames_as_yaml)
say("dot", core._allFramesAsDot)
say("dot", core._allFramesAsDot, rospy.Time(5))
say("dot", core._allFramesAsDot, time=rospy.Time(5))
say("dot", core._allFramesAsDot, 5.0)
for frame in ("a", "b", "/a", "", "nope"):
    say("exists", core._frameExists, frame)
say("exists", core._frameExists, 5)
print(sorted(core._getFrameStrings()))
say("clear", core.clear)
say("after", core.can_transform_core, "a", "b", zero)
say("after", core.all_frames_as_string)
print(issubclass(tf2_py.LookupException, tf2_py.TransformException), tf2_py.TimeoutException("x").args)

class Mine(tf2_py.BufferCore):
    def __init__(self, span):
        tf2_py.BufferCore.__init__(self, rospy.Duration(span))

print(Mine(3)._frameExists("a"))
"""


def test_arguments_types_and_texts(master: Master) -> None:
    said = same(master, ARGUMENTS)
    assert "made" in said and "digraph G" in said


INTEGERS = """
import numpy, rospy, tf, tf2_ros
from geometry_msgs.msg import Quaternion, TransformStamped

message = TransformStamped()
message.header.frame_id, message.child_frame_id, message.transform.rotation = "w", "r", Quaternion(0, 0, 0, 1)
transformer = tf.Transformer()
buffer = tf2_ros.Buffer(debug=False)
for number in (3, True, numpy.float32(2), numpy.int64(-1)):
    message.header.stamp += rospy.Duration(1)
    message.transform.translation.x = number
    transformer.setTransform(message)
    print(transformer.lookupTransform("w", "r", rospy.Time(0)))
    buffer.set_transform(message, "me")
    print(buffer.lookup_transform("w", "r", rospy.Time(0)).transform)
"""


def test_integers_become_floats(master: Master) -> None:
    assert "([3.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0])" in same(master, INTEGERS)
