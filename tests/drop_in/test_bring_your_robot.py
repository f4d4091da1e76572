"""The guide's page "Bring your robot": the commands as they are there, with the packages of a robot.

Feature: "Bring your robot" -- a robot package's messages, services, actions, `.cfg` files and modules, without a
    build
"""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from pyros1.guide.documents import pages

ROOT = Path(__file__).resolve().parents[2]

FILES = {
    "package.xml": "<package><name>my_robot</name></package>",
    "msg/Battery.msg": "Header header\nfloat64 charge\n",
    "srv/Charge.srv": "float64 amount\n---\nfloat64 charge\n",
    "action/Drive.action": "float64 distance\n---\nfloat64 driven\n---\nfloat64 left\n",
    "cfg/Wheels.cfg": """#!/usr/bin/env python
PACKAGE = "my_robot"
from dynamic_reconfigure.parameter_generator_catkin import *
gen = ParameterGenerator()
gen.add("speed", double_t, 0, "Speed in m/s", 0.5, 0.0, 2.0)
exit(gen.generate(PACKAGE, "my_robot", "Wheels"))
""",
    "setup.py": """from distutils.core import setup
from catkin_pkg.python_setup import generate_distutils_setup
setup(**generate_distutils_setup(packages=["my_robot"], package_dir={"": "src"}))
""",
    "src/my_robot/__init__.py": "",
    "src/my_robot/battery.py": "FULL = 12.0\n",
    "scripts/base.py": """#!/usr/bin/env python3
import actionlib
import rospy
from dynamic_reconfigure.server import Server
from my_robot.battery import FULL
from my_robot.cfg import WheelsConfig
from my_robot.msg import Battery, DriveAction, DriveFeedback, DriveResult
from my_robot.srv import Charge, ChargeResponse

rospy.init_node("base")
speed = Server(WheelsConfig, lambda config, level: config).config.speed
rospy.Service("charge", Charge, lambda request: ChargeResponse(min(FULL, request.amount)))
battery = rospy.Publisher("battery", Battery, latch=True, queue_size=1)
battery.publish(charge=FULL)

def drive(goal):
    server.publish_feedback(DriveFeedback(left=goal.distance))
    server.set_succeeded(DriveResult(driven=goal.distance * speed))

server = actionlib.SimpleActionServer("drive", DriveAction, drive, auto_start=False)
server.start()
rospy.spin()
""",
    "scripts/pilot.py": """#!/usr/bin/env python3
import actionlib
import rospy
from my_robot.msg import Battery, DriveAction, DriveGoal
from my_robot.srv import Charge

rospy.init_node("pilot", anonymous=True)
rospy.wait_for_service("charge")
charge = rospy.ServiceProxy("charge", Charge)(50.0).charge
full = rospy.wait_for_message("battery", Battery, 20).charge
client = actionlib.SimpleActionClient("drive", DriveAction)
client.wait_for_server()
client.send_goal_and_wait(DriveGoal(distance=3.0), rospy.Duration(20))
rospy.loginfo("charge %s of %s, driven %s", charge, full, client.get_result().driven)
""",
    "launch/bringup.launch": """<launch>
  <node pkg="my_robot" type="base.py" name="base"/>
  <node pkg="my_robot" type="pilot.py" name="pilot" output="screen" required="true"/>
</launch>
""",
}


def commands() -> str:
    """Return the commands of the page, without those that make and activate an environment."""
    (block,) = pages()["robot"].code("bash")
    first, *others = block.splitlines()
    assert first == "source ~/ros/bin/activate"
    return "\n".join(others)


@pytest.mark.slow
def test_the_page(tmp_path: Path, environ: dict[str, str]) -> None:
    for name, text in FILES.items():
        path = tmp_path / "catkin_ws" / "src" / "my_robot" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)
    programs = tmp_path / "bin"  # as an activated environment has them
    programs.mkdir()
    for name, text in {
        "pyros1": f"exec {shlex.quote(sys.executable)} -m pyros1",
        "python3": f"exec {sys.executable}",
    }.items():
        (programs / name).write_text(f'#!/bin/sh\n{text} "$@"\n')
        (programs / name).chmod(0o755)
    around = {key: value for key, value in os.environ.items() if not key.startswith(("ROS", "PYTHON"))}
    around |= {
        "HOME": str(tmp_path),
        "PATH": f"{programs}:{around['PATH']}",
        "PYTHONPATH": str(ROOT / "src"),
        **environ,
    }
    done = subprocess.run(
        ["bash", "-ec", commands()],
        cwd=tmp_path,
        env=around,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=60,
        check=False,
    )
    assert "charge 12.0 of 12.0, driven 1.5" in done.stdout, done.stdout
    assert done.returncode == 0
