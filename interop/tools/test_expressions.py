"""Expressions as public recipes have them: of `bag filter`, `topic echo --filter`, `transform` and $(eval ...).

Each has the same result as in stock ROS; `expressions_stock.py` asks stock's tools.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
from pathlib import Path
from typing import Any

import pytest
from expression_recipes import ARGUMENTS, EVALS, FILTERS, IMU, JOINTS, ODOM, SCAN, TF, TRANSFORMS
from harness import PEERS, STOCK_PYTHON

from pyros1.bag import BagOutput
from pyros1.bag import open as open_bag
from pyros1.cli.commands.topic_tools._expression import load_modules
from pyros1.cli.commands.topic_tools.transform import make_expression_evaluator
from pyros1.cli.shared.filters import filter_expression
from pyros1.ground.errors import Error, LaunchError
from pyros1.ground.expressions import ExpressionError
from pyros1.ground.timing import Time, TVal
from pyros1.launch.reading.convert import convert_value
from pyros1.launch.reading.expression import evaluate
from pyros1.msgs import Message, load_message

OWN_MASTER = True
MASTERS = ("ours",)
pytestmark = pytest.mark.ours_only

DIFFER = {"lambda x: x"}
"""A function is true in stock; it is refused here."""


def recipes(text: str) -> list[str]:
    return [line for line in text.strip().splitlines() if line]


def write_bag(path: Path) -> None:
    """Write a message of each topic, one in each second."""
    header = load_message("std_msgs/Header")

    def make(kind: str, **fields: Any) -> Any:
        return load_message(kind)(**fields)

    def stamped(kind: str, secs: int, frame: str, **fields: Any) -> Any:
        return make(kind, header=header(stamp=Time(secs, 500_000_000), frame_id=frame), **fields)

    def transform(secs: int, parent: str, child: str) -> Any:
        made = stamped("geometry_msgs/TransformStamped", secs, parent, child_frame_id=child)
        made.transform.rotation.w = 1.0
        return made

    odom = stamped("nav_msgs/Odometry", 2, "odom")
    odom.pose.pose.position.x, odom.pose.pose.position.y = 3.0, -4.0
    odom.pose.pose.orientation.z, odom.pose.pose.orientation.w = math.sqrt(0.5), math.sqrt(0.5)
    odom.twist.twist.linear.x = 0.75
    odom.pose.covariance = [0.0] * 36
    imu = stamped("sensor_msgs/Imu", 6, "imu", orientation_covariance=[-1.0, *[0.0] * 8])
    imu.orientation.x = 1.0
    imu.linear_acceleration.z = 9.81
    status = make("diagnostic_msgs/DiagnosticStatus", level=1, name="Motor left")
    status.values = [make("diagnostic_msgs/KeyValue", key="rpm", value="100")]
    tf = "tf2_msgs/TFMessage"
    messages = [
        (TF, make(tf, transforms=[transform(1, "map", "odom")])),
        (ODOM, odom),
        (SCAN, stamped("sensor_msgs/LaserScan", 3, "laser", ranges=[1.5, 0.25, 2.0, math.inf], angle_max=1.0)),
        (TF, make(tf, transforms=[transform(4, "odom", "base_link"), transform(5, "map", "odom")])),
        ("/diagnostics", stamped("diagnostic_msgs/DiagnosticArray", 5, "", status=[status])),
        (IMU, imu),
        (JOINTS, stamped("sensor_msgs/JointState", 7, "", name=["arm", "elbow"], position=[0.5, 2.0])),
        ("/text", make("std_msgs/String", data="hello")),
        (
            "/image",
            stamped("sensor_msgs/Image", 9, "camera", height=2, width=3, step=3, encoding="mono8", data=b"abcdef"),
        ),
        ("/camera/camera_info", stamped("sensor_msgs/CameraInfo", 10, "camera", K=[500.0, *[0.0] * 8])),
    ]
    with BagOutput(path) as writer:
        for number, (topic, message) in enumerate(messages, 1):
            writer.write(topic, message, Time(number, 0))


def plain(value: Any) -> Any:
    """Return a value as JSON, in the way of `expressions_stock.py`."""
    if isinstance(value, Message):
        return {name: plain(getattr(value, name)) for name in type(value).__slots__}
    if isinstance(value, TVal):
        return value.to_nsec()
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(each) for each in value]
    if isinstance(value, float):
        return round(value, 9) if math.isfinite(value) else str(value)
    return value.decode("latin-1") if isinstance(value, bytes) else value


def stock(bag: Path) -> Any:
    asked = {
        "bag": str(bag),
        "filters": recipes(FILTERS),
        "transforms": TRANSFORMS,
        "evals": EVALS,
        "arguments": ARGUMENTS,
    }
    program = PEERS / "expressions_stock.py"
    done = subprocess.run(
        [STOCK_PYTHON, str(program)], input=json.dumps(asked), capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def filtered(bag: Path, text: str) -> list[int] | None:
    try:
        test = filter_expression(text)
        with open_bag(bag) as opened:
            return [
                message.time.secs
                for message in opened.messages()
                if test({"topic": message.topic, "m": message.message, "t": message.time})
            ]
    except ExpressionError:
        return None


def transformed(message: Any, text: str, modules: list[str]) -> Any:
    try:
        return plain(make_expression_evaluator(text, load_modules(modules, Time))(message))
    except (Error, TypeError):
        return None


def evaluated(text: str) -> str | None:
    arguments = {name: convert_value(value, "auto") for name, value in ARGUMENTS.items()}
    functions = {"arg": arguments.__getitem__, "env": os.environ.__getitem__, "optenv": os.environ.get}
    try:
        return evaluate(text, arguments, functions)
    except LaunchError:
        return None


def test_recipes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = tmp_path / "recipes.bag"
    write_bag(bag)
    expected = stock(bag)
    problems = []
    for text, wanted in zip(recipes(FILTERS), expected["filters"], strict=True):
        found = filtered(bag, text)
        if found != wanted and wanted is not None and text not in DIFFER:
            problems.append((text, wanted, found))
    with open_bag(bag) as opened:
        messages = {message.topic: message.message for message in opened.messages()}
    for (topic, text, modules), wanted in zip(TRANSFORMS, expected["transforms"], strict=True):
        found = transformed(messages[topic], text, modules)  # the values of the fields
        if found not in (wanted, [wanted]) and wanted is not None:
            problems.append((text, wanted, found))
    for text, wanted in zip(EVALS, expected["evals"], strict=True):
        found = evaluated(text)
        if found != wanted and wanted is not None:
            problems.append((text, wanted, found))
    capsys.readouterr()
    assert not problems, "\n".join(map(str, problems))
