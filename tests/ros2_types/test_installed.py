"""ROS 2 definitions in folders."""

from __future__ import annotations

from pathlib import Path

import pytest

from pyros1.ground.errors import DefinitionError
from pyros1.ros2_types import installed
from pyros1.ros2_types.installed import InstalledTypes, PackagesError, environment_folders
from pyros1.ros2_types.model import Field, FieldType


def write(top: Path, path: str, text: str) -> None:
    (top / path).parent.mkdir(parents=True, exist_ok=True)
    (top / path).write_text(text)


def test_packages_of_a_workspace(tmp_path: Path) -> None:
    write(tmp_path, "src/group/my_interfaces/msg/Flat.msg", "int32 x\n")
    write(tmp_path, "src/group/my_interfaces/srv/Add.srv", "int32 a\n---\nint32 b\n")
    write(tmp_path, "src/other-folder/package.xml", "<package><name> renamed </name></package>")
    write(tmp_path, "src/other-folder/action/Go.action", "int8 g\n---\n---\nint8 f\n")
    write(tmp_path, "src/group/my_interfaces/msg/not-a-type.msg", "")
    write(tmp_path, "build/other/msg/Copy.msg", "")
    write(tmp_path, ".git/other/msg/Copy.msg", "")
    types = InstalledTypes([tmp_path])
    assert {*types} == {
        "my_interfaces/msg/Flat",
        "my_interfaces/srv/Add_Request",
        "my_interfaces/srv/Add_Response",
        *(f"renamed/action/Go_{part}" for part in ("Goal", "Result", "Feedback")),
    }
    assert types["my_interfaces/msg/Flat"].fields == (Field("x", FieldType("int32")),)
    assert types["my_interfaces/srv/Add_Response"].fields == (Field("b", FieldType("int32")),)
    assert types["renamed/action/Go_Feedback"].fields == (Field("f", FieldType("int8")),)
    assert "std_msgs/msg/String" not in types and len(types) == 6


def test_other_folders_of_packages_are_not_looked_at(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, "p/package.xml", "<package><name>p</name></package>")
    write(tmp_path, "p/msg/T.msg", "int8 x\n")
    for number in range(20):
        write(tmp_path, f"p/cmake/{number}/msg/T.msg", "int8 x\n")
    monkeypatch.setattr(installed, "MAX_FOLDERS", 3)
    assert [*InstalledTypes([tmp_path])] == ["p/msg/T"]


def test_the_first_folder_counts(tmp_path: Path) -> None:
    for number, folder in enumerate("ab"):
        write(tmp_path, f"{folder}/p/msg/T.msg", f"int8[{number + 1}] x\n")
    assert InstalledTypes([tmp_path / "b", tmp_path / "a"])["p/msg/T"].fields[0].type.size == 2


def test_folders_that_cannot_be_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(PackagesError, match="there is no such folder"):
        InstalledTypes([tmp_path / "missing"])
    with pytest.raises(PackagesError, match="there are no packages"):
        InstalledTypes([tmp_path])
    for number in range(4):
        (tmp_path / str(number)).mkdir()
    monkeypatch.setattr(installed, "MAX_FOLDERS", 4)
    with pytest.raises(PackagesError, match="more than 4 folders"):
        InstalledTypes([tmp_path])


def test_definitions_that_cannot_be_read(tmp_path: Path) -> None:
    write(tmp_path, "p/msg/T.msg", "int32\n")
    types = InstalledTypes([tmp_path])
    with pytest.raises(DefinitionError):
        types["p/msg/T"]
    (tmp_path / "p/msg/T.msg").unlink()
    with pytest.raises(DefinitionError, match="cannot be read"):
        types["p/msg/T"]


def test_a_service_with_the_name_of_a_part_of_one(tmp_path: Path) -> None:
    write(tmp_path, "p/srv/T_Request.srv", "int32 a\n")
    types = InstalledTypes([tmp_path])
    assert {*types} == {"p/srv/T_Request_Request", "p/srv/T_Request_Response"}
    for name in types:
        with pytest.raises(DefinitionError, match="is not defined here"):
            types[name]


def test_folders_of_an_environment(tmp_path: Path) -> None:
    write(tmp_path, "ros/share/std_msgs/msg/String.msg", "string data\n")
    (tmp_path / "empty/share").mkdir(parents=True)
    environ = {"AMENT_PREFIX_PATH": f"{tmp_path}/ros:{tmp_path}/empty::{tmp_path}/missing"}
    assert environment_folders(environ) == [tmp_path / "ros/share"]
    assert environment_folders({}) == []
