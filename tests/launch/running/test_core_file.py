"""What comes with a master (X94)."""

from __future__ import annotations

from pathlib import Path

import pytest

from pyros1.finding.packages import PackageIndex
from pyros1.ground.errors import LaunchError
from pyros1.launch.running.core import CORE_PARAMS
from pyros1.launch.running.core_file import CoreFile, read_core_file

USUAL = """<launch><group ns="/"><param name="rosversion" command="rosversion roslaunch"/>
<param name="rosdistro" command="rosversion -d"/>{}</group></launch>"""
ROSOUT = '<node pkg="rosout" type="rosout" name="rosout" respawn="true"/>'


def read(tmp_path: Path, text: str) -> CoreFile:
    (tmp_path / "roscore.xml").write_text(text)
    return read_core_file({"ROS_ETC_DIR": str(tmp_path)}, PackageIndex({}, installs=[]))


def test_without_a_file(tmp_path: Path) -> None:
    for environ in ({}, {"ROS_ETC_DIR": str(tmp_path)}):
        assert read_core_file(environ, PackageIndex({}, installs=[])) == CoreFile(True, CORE_PARAMS)


def test_the_usual_file_means_what_is_usual(tmp_path: Path) -> None:
    assert read(tmp_path, USUAL.format(ROSOUT)) == CoreFile(True, CORE_PARAMS)


def test_a_file_of_ones_own(tmp_path: Path) -> None:
    more = '<param name="extra" value="7"/><node pkg="minimal_nodes" type="minimal_publisher" name="more"/>'
    found = read(tmp_path, USUAL.format(more))
    assert not found.starts_rosout and found.params == {**CORE_PARAMS, "/extra": 7}
    assert [node.full_name for node in found.nodes] == ["/more"]


def test_a_file_that_cannot_be_used(tmp_path: Path) -> None:
    with pytest.raises(LaunchError, match=r"roscore\.xml:1: "):
        read(tmp_path, "<launch")
