"""The types of installed ROS 2 packages, from their share folders."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from pyros1.ground.errors import UnknownTypeError
from pyros1.ros2_types.distribution import distribution_types
from pyros1.ros2_types.model import Field, FieldType
from pyros1.ros2_types.rclpy_packages import RclpyPackages
from pyros1.ros2_types.type_hash import service_hash, type_hash

TEXTS = {
    "std_msgs/msg/String.msg": "string data\n",
    "lab_msgs/msg/Bench.msg": "std_msgs/String name\nint32 LEGS=4\nfloat64[3] place\n",
    "lab_msgs/msg/Broken.msg": "int32 a\nint32 a\n",
    "lab_msgs/srv/Clean.srv": "string what\n---\nbool done\n",
    "lab_msgs/action/Walk.action": "int32 steps\n---\nint32 done\n---\nfloat32 speed\n",
}


@pytest.fixture
def prefix(tmp_path: Path) -> Path:
    for name, text in TEXTS.items():
        path = tmp_path / "share" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path


@pytest.fixture
def types(prefix: Path) -> RclpyPackages:
    return RclpyPackages([prefix])


def test_messages(types: RclpyPackages) -> None:
    assert "lab_msgs/msg/Bench" in types and "lab_msgs/msg/Chair" not in types
    assert types["lab_msgs/msg/Bench"].fields[0] == Field("name", FieldType("std_msgs/msg/String"))
    standard = distribution_types()
    assert types.hash_of("std_msgs/msg/String") == type_hash("std_msgs/msg/String", standard)
    assert types.hash_of("lab_msgs/msg/Bench") == type_hash("lab_msgs/msg/Bench", types)
    assert types.packages() == ["lab_msgs", "std_msgs"]


def test_services_and_actions(types: RclpyPackages) -> None:
    assert types["lab_msgs/srv/Clean_Request"].fields == (Field("what", FieldType("string")),)
    assert types.hash_of("lab_msgs/srv/Clean") == service_hash("lab_msgs/srv/Clean", types)
    goal = types["lab_msgs/action/Walk_SendGoal_Request"]
    assert goal.fields[1] == Field("goal", FieldType("lab_msgs/action/Walk_Goal"))
    for part in ("SendGoal", "GetResult"):
        name = f"lab_msgs/action/Walk_{part}"
        assert types.problem(name) == "" and types.hash_of(name) == service_hash(name, types)
    assert types.hash_of("lab_msgs/action/Walk_FeedbackMessage").startswith("RIHS01_")


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("std_msgs/msg/String", ""),
        ("lab_msgs/srv/Clean", ""),
        ("lab_msgs/action/Walk_SendGoal", ""),
        ("yard_msgs/msg/Tree", "package yard_msgs is not installed in this ROS 2 installation"),
        ("lab_msgs/msg/Chair", "package lab_msgs of this ROS 2 installation has no msg/Chair"),
        ("lab_msgs/srv/Bench", "package lab_msgs of this ROS 2 installation has no srv/Bench"),
        ("lab_msgs/msg/Broken", "the definition of lab_msgs/msg/Broken cannot be read: "),
        ("../share/msg/Bench", "'../share/msg/Bench' is not the name of a ROS 2 type"),
        ("json/msg/Decoder", "package json is not installed in this ROS 2 installation"),
    ],
)
def test_problems(types: RclpyPackages, name: str, problem: str) -> None:
    assert types.problem(name).startswith(problem) and bool(types.problem(name)) == bool(problem)
    if problem:
        assert name not in types
        with pytest.raises(UnknownTypeError):
            types.hash_of(name)


def test_the_folder_of_the_python_package_comes_first(
    prefix: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As colcon installs it: PREFIX/lib/python3.11/site-packages and PREFIX/share."""
    other = tmp_path / "other"
    for folder in ("lib/python3.11/site-packages/lab_msgs", "share/lab_msgs/msg"):
        (other / folder).mkdir(parents=True)
    site = other / "lib/python3.11/site-packages"
    (site / "lab_msgs" / "__init__.py").write_text("raise AssertionError('it was imported')\n")
    (other / "share/lab_msgs/msg/Bench.msg").write_text("string other\n")
    monkeypatch.setattr(sys, "path", [str(site), *sys.path])
    assert RclpyPackages([prefix])["lab_msgs/msg/Bench"].fields == (Field("other", FieldType("string")),)


def test_ament_prefix_path(prefix: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"/nowhere:{prefix}")
    assert "lab_msgs/msg/Bench" in RclpyPackages()


def test_a_type_without_a_text(prefix: Path, types: RclpyPackages) -> None:
    kind = {"type_id": 17, "capacity": 0, "string_capacity": 0, "nested_type_name": ""}
    described = {"type_name": "lab_msgs/msg/Idl", "fields": [{"name": "text", "type": kind}]}
    text = json.dumps({"type_description_msg": {"type_description": described, "referenced_type_descriptions": []}})
    (prefix / "share/lab_msgs/msg/Idl.json").write_text(text)
    assert types["lab_msgs/msg/Idl"].fields == (Field("text", FieldType("string")),)


def test_much_that_is_not_there_is_forgotten(
    prefix: Path, types: RclpyPackages, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.ros2_types.rclpy_packages.MAX_PACKAGES", 5)
    assert types.problem("no_0/msg/Tree")
    (prefix / "share/no_0/msg").mkdir(parents=True)
    (prefix / "share/no_0/msg/Tree.msg").write_text("")
    assert types.problem("no_0/msg/Tree"), "it is remembered"
    for number in range(1, 10):
        assert types.problem(f"no_{number}/msg/Tree")
    assert not types.problem("no_0/msg/Tree") and "lab_msgs/msg/Bench" in types
