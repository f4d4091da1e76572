"""The nodes tf_change_notifier and buffer_server (L199)."""

from __future__ import annotations

import math
import os
import queue
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import pyros1
from pyros1.cli.commands.tf.change_notifier import FramePair
from pyros1.cli.main import entry
from pyros1.msgs import load_message
from pyros1.node import Node
from pyros1.tf import BufferClient, TransformBroadcaster

PACKAGES = Path(pyros1.__file__).parent / "packages"
SOURCES = PACKAGES.parents[1]
Make = Callable[..., Node]


def stamped(parent: str, child: str, node: Node, x: float) -> Any:
    message: Any = load_message("geometry_msgs/TransformStamped")()
    message.header.frame_id, message.child_frame_id, message.header.stamp = parent, child, node.now()
    message.transform.translation.x = x
    message.transform.rotation.w = 1.0
    return message


def pose(x: float = 0.0, yaw: float = 0.0, sign: int = 1) -> Any:
    transform: Any = load_message("geometry_msgs/Transform")()
    transform.translation.x = x
    transform.rotation.z, transform.rotation.w = sign * math.sin(yaw / 2), sign * math.cos(yaw / 2)
    return transform


def test_what_counts_as_a_move() -> None:
    """Small steps add up; turns are measured as half the angle, the sign of a quaternion means nothing."""
    pair = FramePair("base", "map")
    poses = [pose(), pose(), pose(0.09), pose(0.11), pose(0.2), pose(0.22)]
    assert [pair.check_moved(each) for each in poses] == [True, False, False, True, False, True]
    pair = FramePair("base", "map")
    poses = [pose(), pose(sign=-1), pose(yaw=0.19), pose(yaw=0.21), pose(yaw=0.4), pose(yaw=0.42)]
    assert [pair.check_moved(each) for each in poses] == [True, False, False, True, False, True]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["change_notifier", "_frame_pairs:=5"], "~frame_pairs must be a list"),
        (["change_notifier", "_frame_pairs:=[5]"], "~frame_pairs must be a list"),
        (["change_notifier", "_frame_pairs:=[{source_frame: a}]"], "target_frame must be a frame name"),
        (
            ["change_notifier", "_frame_pairs:=[{source_frame: a, target_frame: 3}]"],
            "target_frame must be a frame name",
        ),
        (
            ["change_notifier", "_angular_update_distance:=far"],
            "~angular_update_distance must be a non-negative number",
        ),
        (["change_notifier", "_translational_update_distance:=-1"], "~translational_update_distance must be"),
        (["change_notifier", "_polling_frequency:=0"], "~polling_frequency must be greater than 0"),
        (["buffer_server", "_buffer_size:=0"], "~buffer_size must be a number of seconds greater than 0"),
        (["buffer_server", "_buffer_size:=long"], "~buffer_size must be a number of seconds greater than 0"),
    ],
)
def test_wrong_parameters(
    words: list[str], said: str, environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    assert entry(["pyros1", "tf", *words]) == 1
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("verb", ["change_notifier", "buffer_server"])
def test_arguments(verb: str, capsys: Any) -> None:
    with pytest.raises(SystemExit) as end:
        entry(["pyros1", "tf", verb, "base"])
    assert end.value.code == 2
    with pytest.raises(SystemExit) as end:
        entry(["pyros1", "tf", verb, "-h"])
    assert end.value.code == 0
    assert "Examples:" in capsys.readouterr().out


@pytest.mark.slow
def test_the_nodes_of_the_packages(environ: dict[str, str], make_node: Make) -> None:
    """Both at once: they do what they are there for."""
    robot = make_node("robot")
    changes: queue.Queue[Any] = queue.Queue()
    robot.subscribe("/tf_changes", "tf/tfMessage", changes.put)
    moving = TransformBroadcaster(robot)
    positions = [0.0]
    robot.timer(0.05, lambda _: moving.send_transform(stamped("map", "base_link", robot, positions[-1])))
    scripts = ["tf/scripts/tf_change_notifier", "tf2_ros/scripts/buffer_server"]
    env = {**os.environ, **environ, "PYTHONPATH": str(SOURCES)}
    children = [
        subprocess.Popen(
            [sys.executable, str(PACKAGES / script)], env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        for script in scripts
    ]
    try:
        for position in (0.0, 5.0):
            positions.append(position)
            (change,) = changes.get(timeout=20).transforms
            assert (change.header.frame_id, change.child_frame_id) == ("/map", "/base_link")
            assert change.transform.translation.x == position
        client = BufferClient(robot)
        assert client.lookup_transform("map", "base_link", timeout=20).transform.translation.x == 5.0
    finally:
        for child in children:
            child.terminate()
        for child in children:
            child.wait(20)
    assert [child.returncode for child in children] == [0, 0]
