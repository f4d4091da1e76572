"""Type checkers and editors know our modules and message packages under stock's names."""

from __future__ import annotations

import ast
import subprocess
import sys
import venv
from pathlib import Path

import pytest

from pyros1.drop_in.environment import disable, enable
from pyros1.drop_in.finder import MODULES_FOLDER
from pyros1.drop_in.stubs import write_stubs
from pyros1.finding.library import Library

pytestmark = pytest.mark.once

SOURCE = Path(__file__).resolve().parents[2] / "src"

PROGRAM = """
import actionlib
import rospy
import rospy.names
import tf2_ros
from geometry_msgs.msg import Twist
from my_robot.msg import State
from my_robot.srv import Go, GoResponse
from rosgraph import Master
from sensor_msgs import point_cloud2
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Float64

def got(message: State) -> None:
    message.twist.linear.x = 1.0
    message.twist.linear.x = "fast"  # wrong
    message.speed = 1.0  # wrong

rospy.init_node("node", anonymous=True)
publisher = rospy.Publisher("topic1", Float64, queue_size=1)
publisher.publish(1.0)
publisher.unadvertise()  # wrong
rospy.Subscriber("state", State, got)
rospy.Service("go", Go, lambda request: GoResponse(done=request.fast))
rospy.init_nod("node")  # wrong
rospy.Time.now().to_sec() + rospy.names.resolve_name("x")  # wrong
State(twist=Twist(), battery=0.5)
State(batery=0.5)  # wrong
tf2_ros.Buffer().lookup_transform("a", "b", rospy.Time())
from std_msgs.msg import Flot64  # wrong
"""


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    """The folder of a package with a message and a service."""
    folder = tmp_path / "robot" / "my_robot"
    for name, text in {
        "package.xml": "<package><name>my_robot</name></package>",
        "msg/State.msg": "geometry_msgs/Twist twist\nfloat32 battery\n",
        "srv/Go.srv": "bool fast\n---\nbool done\n",
    }.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder


@pytest.mark.slow
def test_mypy_knows_them(tmp_path: Path, robot: Path) -> None:
    venv.create(tmp_path / "venv", symlinks=True)
    (site,) = tmp_path.glob("venv/lib/python*/site-packages")
    (site / "pyros1.pth").write_text(f"{SOURCE}\n")
    _, errors = enable(str(site), {"ROS_PACKAGE_PATH": str(robot.parent)})
    assert not errors
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    options = ["--cache-dir", str(tmp_path / "cache"), "--config-file=", "--python-executable"]
    done = subprocess.run(
        [sys.executable, "-m", "mypy", *options, str(tmp_path / "venv" / "bin" / "python"), str(program)],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    lines = {int(line.split(":")[1]) for line in done.stdout.splitlines() if "program.py:" in line and "error" in line}
    wrong = {number for number, line in enumerate(PROGRAM.splitlines(), 1) if line.endswith("# wrong")}
    assert lines == wrong, done.stdout + done.stderr
    assert disable(str(site))


def test_every_module_has_one(tmp_path: Path) -> None:
    assert not write_stubs(tmp_path, Library({}))
    for source in Path(MODULES_FOLDER).rglob("*.py"):
        top, *rest = source.relative_to(MODULES_FOLDER).parts
        stub = tmp_path.joinpath(f"{top}-stubs", *rest).with_suffix(".pyi")
        (imported,) = ast.parse(stub.read_text()).body
        assert isinstance(imported, ast.ImportFrom)
    for package in Library({}).packages():
        assert (tmp_path / f"{package}-stubs" / "__init__.pyi").is_file()


def test_a_package_with_a_wrong_definition_is_named(tmp_path: Path, robot: Path) -> None:
    (robot / "msg" / "Bad.msg").write_text("float64 1x\n")
    (error,) = write_stubs(tmp_path / "stubs", Library({"ROS_PACKAGE_PATH": str(robot.parent)}))
    assert "Bad.msg" in error
    assert "1x" in error
    assert not (tmp_path / "stubs" / "my_robot-stubs").exists()
    assert (tmp_path / "stubs" / "rospy-stubs").is_dir()


def test_earlier_stubs_are_replaced(tmp_path: Path, robot: Path) -> None:
    write_stubs(tmp_path / "stubs", Library({"ROS_PACKAGE_PATH": str(robot.parent)}))
    assert "class State" in (tmp_path / "stubs" / "my_robot-stubs" / "msg.pyi").read_text()
    write_stubs(tmp_path / "stubs", Library({}))
    assert not (tmp_path / "stubs" / "my_robot-stubs").exists()
