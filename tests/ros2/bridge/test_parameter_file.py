"""The parameters of ros1_bridge's parameter_bridge."""

from __future__ import annotations

from pathlib import Path

import pytest

from pyros1.bridge.rules.file_reader import RulesError
from pyros1.ros2.bridge.parameter_file import MAX_SIZE, BridgeParameters, read_parameters
from pyros1.values.reading import YamlError

EXAMPLE = """\
topics:
  -
    topic: /chatter  # ROS1 topic name
    type: std_msgs/msg/String  # ROS2 type name
    queue_size: 1  # For the publisher back to ROS1
  - topic: map
    type: nav_msgs/msg/OccupancyGrid
    qos:
      durability: transient_local
services_1_to_2:
  - {service: /add_two_ints, type: example_interfaces/srv/AddTwoInts}
services_2_to_1:
  - {service: /clear, type: std_srvs/Empty}
something: else
"""


def read(folder: Path, text: str) -> BridgeParameters:
    (folder / "bridge.yaml").write_text(text)
    return read_parameters(folder / "bridge.yaml")


def test_all_lists(tmp_path: Path) -> None:
    assert read(tmp_path, EXAMPLE) == BridgeParameters(
        ["/chatter", "/map", "/add_two_ints", "/clear"],
        [f"{tmp_path}/bridge.yaml:8: qos is not used: for /map, it follows from what the nodes offer"],
    )


@pytest.mark.parametrize(
    ("text", "line", "complaint"),
    [
        ("", None, "it has none of the lists topics, services_1_to_2, services_2_to_1"),
        ("other: 1\n", 1, "it has none of the lists"),
        ("- a\n", 1, "expected a mapping"),
        ("topics:\n- /chatter\n", 2, "expected a mapping"),
        ("topics:\n- {type: std_msgs/msg/String}\n", 2, "topic is missing"),
        ("services_1_to_2:\n- {topic: /a}\n", 2, "there is no setting 'topic'"),
        ("topics:\n- topic: 3\n", 2, "expected a string"),
        ("topics:\n- topic: /a/**\n", 2, "is not the name of a topic or service"),
        ("topics:\n- topic: red:/a\n", 2, "is not the name"),
    ],
)
def test_what_is_refused(tmp_path: Path, text: str, line: int | None, complaint: str) -> None:
    with pytest.raises(RulesError) as caught:
        read(tmp_path, text)
    place = f"{tmp_path}/bridge.yaml" + (f":{line}" if line else "")
    assert str(caught.value).startswith(f"{place}: ") and complaint in str(caught.value)


def test_files_that_are_not_yaml_or_too_large(tmp_path: Path) -> None:
    with pytest.raises(YamlError):
        read(tmp_path, "topics: {\n")
    with pytest.raises(RulesError, match="larger than"):
        read(tmp_path, "#" * (MAX_SIZE + 1))
    with pytest.raises(FileNotFoundError):
        read_parameters(tmp_path / "missing")
