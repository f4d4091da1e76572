"""Words for programs of other times and places: in callbacks, too; and odd settings."""

from __future__ import annotations

import subprocess
import sys

import pytest
from programs import run

from pyros1.drop_in import environment
from pyros1.ground.errors import Error

CALLBACK = """
import threading, time, rospy
from std_msgs.msg import String
rospy.init_node("old")
calls = []
done = threading.Event()
def callback(message):
    calls.append(message.data)
    if len(calls) == 3:
        done.set()
    if len(calls) < 3:
        {}.iteritems()
    unicode("x")
rospy.Subscriber("/old", String, callback)
publisher = rospy.Publisher("/old", String, queue_size=10)
end = time.monotonic() + 15
while not publisher.get_num_connections():
    assert time.monotonic() < end, "not in time"
    time.sleep(0.005)
for number in range(3):
    publisher.publish(str(number))
assert done.wait(20)
rospy.signal_shutdown("end")
"""


def test_a_callback_in_python_2_gets_a_word_once(environ: dict[str, str]) -> None:
    out = run(CALLBACK, environ)
    assert out.count("bad callback") >= 1
    assert out.count("this looks like a program for Python 2") == 1


def test_a_wrong_choice_of_rospy_is_said(environ: dict[str, str]) -> None:
    out = run("import rospy; print(rospy.__name__)", {**environ, "PYROS1_ROSPY": "ours"})
    assert out.count("PYROS1_ROSPY is 'ours', not 'pyros1' or 'stock': it is ignored") == 1
    assert "rospy" in out.splitlines()


def test_an_interpreter_that_does_not_start(monkeypatch: pytest.MonkeyPatch) -> None:
    def hang(*args: object, **kwargs: object) -> None:
        raise subprocess.TimeoutExpired("python", 30)

    monkeypatch.setattr("pyros1.drop_in.environment.subprocess.run", hang)
    with pytest.raises(Error, match=f"{sys.executable} does not start within 30 s"):
        environment.installed_rospy()
