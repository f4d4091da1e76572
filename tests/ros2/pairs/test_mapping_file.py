"""Files of mapping rules, in the format of ros1_bridge, and what is wrong in them."""

from __future__ import annotations

from pathlib import Path

import pytest

from pyros1.bridge.rules.file_reader import RulesError
from pyros1.ros2.pairs.mapping_file import MAX_SIZE, read_mappings
from pyros1.ros2_types.mapping import PackageRule, TypeRule
from pyros1.values.reading import YamlError

PACKAGES = "- ros1_package_name: a_msgs\n  ros2_package_name: a_interfaces\n"
MESSAGE = f"{PACKAGES}  ros1_message_name: Pose2\n  ros2_message_name: Flat\n"
SERVICE = f"{PACKAGES}  ros1_service_name: TwoInts\n  ros2_service_name: AddTwoInts\n"


def write(folder: Path, text: str, name: str = "map.yaml") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def test_all_kinds_of_rules(tmp_path: Path) -> None:
    fields = "  fields_1_to_2:\n    header.stamp: 'stamp'\n    Pos: position\n"
    parts = "  request_fields_1_to_2: {a: x}\n  response_fields_1_to_2:\n    sum: total\n"
    foreign = "  enable_foreign_mappings: true\n"
    path = write(tmp_path, MESSAGE + fields + SERVICE + parts + PACKAGES + foreign)
    mapping = read_mappings([path])
    assert mapping.packages == (PackageRule("a_msgs", "a_interfaces", f"{path}:15"),)
    assert mapping.rules == (
        TypeRule(
            "a_msgs/Pose2",
            "a_interfaces/msg/Flat",
            {"header.stamp": "stamp", "Pos": "position"},
            None,
            f"{path}:1",
        ),
        TypeRule("a_msgs/TwoInts", "a_interfaces/srv/AddTwoInts", {"a": "x"}, {"sum": "total"}, f"{path}:8"),
    )


def test_several_files_and_files_without_rules(tmp_path: Path) -> None:
    paths = [write(tmp_path, text, str(number)) for number, text in enumerate([MESSAGE, SERVICE, "", "[]", "# none\n"])]
    assert [rule.ros1 for rule in read_mappings(paths).rules] == ["a_msgs/Pose2", "a_msgs/TwoInts"]


@pytest.mark.parametrize(
    ("text", "line", "complaint"),
    [
        ("a: b\n", 1, "is a list"),
        ("word", None, "is a list"),
        ("- word\n", 1, "expected a mapping"),
        ("- ros1_package_name: a\n", 1, "the rule needs ros2_package_name"),
        (PACKAGES + "  ros1_message_name: A\n", 1, "the rule needs ros2_message_name"),
        (PACKAGES + "  ros2_service_name: A\n", 1, "the rule needs ros1_service_name"),
        (PACKAGES + "  ros1_mesage_name: A\n", 3, "there is no setting 'ros1_mesage_name'"),
        (PACKAGES + "  ros1_package_name: b\n", 3, "was already set in line 1"),
        (PACKAGES + "  enable_foreign_mappings: 3\n", 3, "expected true or false"),
        (PACKAGES + "  fields_1_to_2: {a: b}\n", 3, "add ros1_message_name and ros2_message_name"),
        (MESSAGE + "  request_fields_1_to_2: {a: b}\n", 5, "add ros1_service_name and ros2_service_name"),
        (MESSAGE + "  ros1_service_name: A\n", 1, "write two rules"),
        (MESSAGE + "  fields_1_to_2: [a]\n", 5, "expected a mapping"),
        (MESSAGE + "  fields_1_to_2:\n    a: b\n    a: c\n", 7, "was already set in line 6"),
        (MESSAGE + "  fields_1_to_2:\n    a: b\n    c: b\n", 7, "'b' is already matched with 'a'"),
        (MESSAGE + "  fields_1_to_2:\n    a: 3\n", 6, "3 is not a field"),
        (MESSAGE + "  fields_1_to_2:\n    a.: b\n", 6, "'a.' is not a field"),
        ("- ros1_package_name: a/b\n  ros2_package_name: c\n", 1, "'a/b' is not a name"),
        ("- ros1_package_name: 3\n  ros2_package_name: c\n", 1, "expected a string"),
        (MESSAGE + MESSAGE, 5, "there is already a rule for a_msgs/Pose2 and a_interfaces/msg/Flat"),
        (MESSAGE + MESSAGE.replace("Flat", "Other"), 5, "is already a_interfaces/msg/Flat in ROS 2"),
        (PACKAGES + PACKAGES, 3, "there is already a rule for a_msgs and a_interfaces"),
    ],
)
def test_what_is_refused(tmp_path: Path, text: str, line: int | None, complaint: str) -> None:
    path = write(tmp_path, text)
    with pytest.raises(RulesError) as caught:
        read_mappings([path])
    assert str(caught.value).startswith(f"{path}:{line}: " if line else str(path)) and complaint in str(caught.value)


def test_a_package_may_be_several(tmp_path: Path) -> None:
    path = write(tmp_path, PACKAGES + PACKAGES.replace("a_int", "b_int"))
    assert [rule.ros2 for rule in read_mappings([path]).packages] == ["a_interfaces", "b_interfaces"]


def test_a_message_and_a_service_of_one_name_are_two(tmp_path: Path) -> None:
    service = SERVICE.replace("TwoInts", "Pose2")
    assert len(read_mappings([write(tmp_path, MESSAGE + service)]).rules) == 2


def test_two_files_must_not_contradict_each_other(tmp_path: Path) -> None:
    first, second = write(tmp_path, MESSAGE, "first"), write(tmp_path, MESSAGE.replace("Flat", "Other"), "second")
    with pytest.raises(RulesError, match=rf"{second}:1: .* see {first}:1"):
        read_mappings([first, second])


def test_files_that_are_not_yaml_or_too_large(tmp_path: Path) -> None:
    with pytest.raises(YamlError, match=r"map.yaml:2"):
        read_mappings([write(tmp_path, "- a: b\n c: {\n")])
    with pytest.raises(RulesError, match="larger than"):
        read_mappings([write(tmp_path, "#" * (MAX_SIZE + 1))])
    with pytest.raises(FileNotFoundError):
        read_mappings([tmp_path / "missing"])
