"""roslaunch by pyros1 as a library, in programs as users write them."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from programs import run

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="scripts with #!")
NODE = """#!/bin/sh
trap 'exit 0' INT TERM
[ "$1" = stay ] || exit "$1"
while :; do sleep 0.05; done
"""


@pytest.fixture
def environ_with_package(environ: dict[str, str], tmp_path: Path) -> dict[str, str]:
    folder = tmp_path / "scripted"
    folder.mkdir()
    (folder / "package.xml").write_text("<package><name>scripted</name><version>1.0.0</version></package>")
    (folder / "run").write_text(NODE)
    (folder / "run").chmod(0o755)
    (folder / "a.launch").write_text(
        "<launch><arg name='x'/><param name='p' value='$(arg x)'/>"
        "<node pkg='scripted' type='run' name='n' args='4'/></launch>"
    )
    return {**environ, "ROS_PACKAGE_PATH": str(folder)}


PROGRAM = """
import queue
import roslaunch
uuid = roslaunch.rlutil.get_or_generate_uuid(None, False)
roslaunch.configure_logging(uuid)
heard = queue.Queue()
class Listener(roslaunch.pmon.ProcessListener):
    def process_died(self, name, exit_code):
        heard.put((name, exit_code))
files = roslaunch.rlutil.resolve_launch_arguments(["scripted", "a.launch"])
launch = roslaunch.parent.ROSLaunchParent(uuid, [(files[0], ["x:=5"])], process_listeners=[Listener()])
launch.start(auto_terminate=False)
print(heard.get(timeout=20))
process, started = launch.runner.launch_node(roslaunch.core.Node("scripted", "run", name="more", args="stay"))
print(process, started, launch.pm.has_process(process.name), launch.pm.get_process(process.name) is process)
launch.shutdown()
print(process.is_alive(), process.get_info()["alive"], launch.pm.get_active_names())
print([(each.name, each.exit_code) for each in launch.pm.dead_list if each.name == "n-1"])
try:
    launch.start()
except roslaunch.RLException as error:
    print(error)
"""


def test_a_launch_file_and_more(environ_with_package: dict[str, str]) -> None:
    out = run(PROGRAM, environ_with_package)
    assert "('n-1', 4)" in out
    assert "Process<more-2> True True True" in out
    assert "False False []" in out
    assert "[('n-1', 4)]" in out
    assert "this launch was already started" in out


ENDS = """
import roslaunch
launch = roslaunch.parent.ROSLaunchParent(None, [], roslaunch_strs=[
    "<launch><node pkg='scripted' type='run' name='n' args='3'/></launch>"])
launch.start()
launch.pm.join(20)
print(launch.pm.is_alive(), launch.pm.done, launch.pm.get_process_names_with_spawn_count())
for name in ("register", "shown"):
    try:
        getattr(launch.pm, name)
    except AttributeError as error:
        print(error)
launch.shutdown()
"""


def test_the_monitor_ends_with_its_launch(environ_with_package: dict[str, str]) -> None:
    """Programs wait for it: ``while launch.pm.is_alive()``."""
    out = run(ENDS, environ_with_package)
    assert "False True [[], [('n-1', 1)]]" in out
    assert "pyros1 has no ProcessMonitor.register: pyros1 starts processes itself" in out
    assert "'ProcessMonitor' object has no attribute 'shown'" in out


SCRIPT = """
import roslaunch
from roslaunch import RLException, scriptapi
launch = scriptapi.ROSLaunch()
launch.load_str("<launch><node pkg='scripted' type='run' name='first' args='stay'/></launch>")
launch.start()
print(launch.parent.pm.get_active_names())
process = launch.launch(roslaunch.core.Node("scripted", "run", "second", args="stay"))
print(process.is_alive(), launch.spin_once())
process.stop()
print(f"alive: {process.is_alive()}")
try:
    launch.launch(roslaunch.core.Node("nowhere", "run", "third"))
except RLException as error:
    print(type(error).__name__, error)
for arguments in ({"name": "x/y"}, {"output": "odd"}, {"cwd": "odd"}):
    try:
        roslaunch.core.Node("scripted", "run", **arguments)
    except ValueError as error:
        print(type(error).__name__, error)
launch.stop()
print(f"running: {launch.spin_once()}")
for name in ("child",):
    try:
        getattr(roslaunch, name)
    except AttributeError as error:
        print(error)
"""


def test_nodes_of_a_program(environ_with_package: dict[str, str]) -> None:
    out = run(SCRIPT, environ_with_package)
    assert "['first-1']\n" in out
    assert "True True" in out
    assert "alive: False" in out
    assert "running: False" in out
    assert "RLException" in out
    assert "ValueError node name cannot contain a namespace" in out
    assert "ValueError output must be one of 'log', 'screen', not [odd]" in out
    assert "ValueError cwd must be one of 'ROS_HOME', 'node', not [odd]" in out
    assert "pyros1 has no roslaunch.child" in out
