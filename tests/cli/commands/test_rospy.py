"""`pyros1 rospy`, and programs that `pyros1 run` and `launch` start."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from pyros1.drop_in.finder import MODULES_FOLDER
from pyros1.finding.python_modules import DROP_IN_START

SOURCE = Path(__file__).resolve().parents[3] / "src"


def pyros1(*words: str, environ: dict[str, str]) -> str:
    """Return what a command prints."""
    done = subprocess.run(
        [sys.executable, "-m", "pyros1", *words],
        env={"PATH": os.environ["PATH"], "HOME": "/nonexistent", "PYTHONPATH": str(SOURCE), **environ},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=60,
        check=False,
    )
    return done.stdout


def test_status_says_which_rospy_runs(environ: dict[str, str]) -> None:
    shown = pyros1("rospy", "status", environ={"PYTHONPATH": f"{DROP_IN_START}:{SOURCE}"})
    assert f"Python:  {sys.executable}\nrospy:   pyros1's, {MODULES_FOLDER}/rospy\nenabled: no\n" in shown
    assert "rospy:   none; " in pyros1("rospy", "status", environ={})


def test_status_tells_of_a_real_one(tmp_path: Path) -> None:
    (tmp_path / "rospy.py").touch()
    assert f"a real one, {tmp_path}, which takes precedence" in pyros1(
        "rospy", "status", environ={"PYTHONPATH": f"{tmp_path}:{SOURCE}"}
    )


@pytest.mark.parametrize("verb", ["enable", "disable", "status"])
def test_no_verb_takes_arguments(verb: str) -> None:
    assert f"{verb} takes no arguments" in pyros1("rospy", verb, "my_package", environ={})


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A ROS package with a node that needs rospy."""
    folder = tmp_path / "old_robot"
    (folder / "scripts").mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>old_robot</name></package>")
    node = folder / "scripts" / "node.py"
    node.write_text(f"""#!{sys.executable}
import rospy
from std_msgs.msg import String
rospy.init_node("node")
print("runs on", rospy.__file__, rospy.get_name(), rospy.get_param("~text", "none"))
""")
    node.chmod(0o755)
    return folder


@pytest.mark.slow
def test_a_node_that_imports_rospy_runs(package: Path, environ: dict[str, str]) -> None:
    found = {**environ, "ROS_PACKAGE_PATH": str(package.parent)}
    shown = pyros1("run", "old_robot", "node.py", "_text:=hello", environ=found)
    assert shown == f"runs on {MODULES_FOLDER}/rospy/__init__.py /node hello\n"


@pytest.mark.slow
def test_a_launched_node_that_imports_rospy_runs(package: Path, environ: dict[str, str]) -> None:
    file = package / "one.launch"
    file.write_text("""<launch>
  <node pkg="old_robot" type="node.py" name="renamed" output="screen" required="true">
    <param name="text" value="launched"/>
    <env name="PYTHONPATH" value="/mine"/>
  </node>
</launch>
""")
    shown = pyros1("launch", str(file), environ={**environ, "ROS_PACKAGE_PATH": str(package.parent)})
    assert f"runs on {MODULES_FOLDER}/rospy/__init__.py /renamed launched\n" in shown
