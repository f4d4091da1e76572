"""The page about the nodes of public robots, and how they are counted."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[1]
LAUNCH_FILE = """
<launch>
  <arg name="driver" default="base_driver"/>
  <node pkg="$(arg driver)" type="base" name="base"/>
  <node pkg="own_nodes" type="talker" name="talker"/>
  <group><node pkg="joy" type="joy_node" name="a"/><node pkg="joy" type="joy_node" name="b"/></group>
  <node pkg="nodelet" type="nodelet" name="m" args="manager"/>
  <node pkg="nodelet" type="nodelet" name="n" args="load image_proc/rectify m --no-bond"/>
  <node pkg="nodelet" type="nodelet" name="o" args="load own_nodes/Driver m"/>
  <node pkg="$(arg unknown)" type="$(arg unknown)_node" name="u"/>
  <!-- <node pkg="commented" type="out" name="c"/> -->
</launch>
"""

STARTED_ELSEWHERE = {
    ("dynamic_reconfigure", "dynparam"),
    ("image_proc", "crop_decimate"),  # as rectify is
    ("image_proc", "debayer"),
    ("image_proc", "rectify"),  # as a nodelet
    ("rosbag", "play"),
    ("rostopic", "rostopic"),
    ("rqt_gui", "rqt_gui"),
    ("rqt_reconfigure", "rqt_reconfigure"),
    ("rviz", "rviz"),
    ("teleop_twist_keyboard", "teleop_twist_keyboard.py"),
    ("yocs_cmd_vel_mux", "cmd_vel_mux"),
    ("yocs_velocity_smoother", "velocity_smoother"),
}
"""The programs that only their own tests start, or the one of nodelets."""


@pytest.fixture
def robots() -> ModuleType:
    spec = importlib.util.spec_from_file_location("robots", ROOT / "interop" / "robots.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["robots"] = module
    try:
        spec.loader.exec_module(module)
    finally:
        del sys.modules["robots"]
    return module


def test_the_page_is_current(robots: ModuleType) -> None:
    assert robots.PAGE.read_text(encoding="utf-8") == robots.page(), "run python interop/robots.py"
    rows, num_robots, _ = robots.read_table()
    assert num_robots == 32 and sum(row.tags for row in rows) > 800


def test_every_program_that_runs_is_tested_and_started(robots: ModuleType) -> None:
    """Feature: interop/robots.md says of each node of public robots' launch files whether it runs, and what tests it"""
    programs = {row.program for row in robots.read_table()[0] if row.runs}
    tests = robots.read_tests()
    assert {*tests} == programs
    for (package, program), files in tests.items():
        assert files
        for file in files:
            text = (ROOT / "tests" / file).read_text(encoding="utf-8")
            assert program.removesuffix(".py") in text or package in text, (
                f"{file} has nothing about {package} {program}"
            )
    started = (ROOT / "tests" / robots.LAUNCH_TEST).read_text(encoding="utf-8")
    missing = {(package, program) for package, program in programs if f"\n{package} {program} " not in started}
    assert missing == STARTED_ELSEWHERE


def test_nodes_are_counted(robots: ModuleType, tmp_path: Path) -> None:
    repository = tmp_path / "somebody+robot"
    (repository / "own_nodes" / "launch").mkdir(parents=True)
    (repository / "own_nodes" / "package.xml").write_text("<package><name> own_nodes </name></package>")
    (repository / "own_nodes" / "launch" / "a.launch").write_text(LAUNCH_FILE)
    (repository / "own_nodes" / "launch" / "b.xml").write_text("<launch><node pkg='joy' type='joy_node'/></launch>")
    (repository / "own_nodes" / "launch" / "damaged.launch").write_text("<launch><node")
    (repository / "own_nodes" / "other.xml").write_text("<launch><node pkg='joy' type='joy_node'/></launch>")
    for words in ("init -q", "checkout -q -b noetic-devel", "add .", "commit -q -m x"):
        command = ["git", "-C", str(repository), "-c", "user.name=x", "-c", "user.email=x@example.com", *words.split()]
        subprocess.run(command, check=True, timeout=60)
    assert robots.scan([str(repository)]).splitlines() == [
        "# somebody/robot\tnoetic-devel\t2 nodes of its own packages",
        "base_driver\tbase\t-\t1\t1",
        "by-argument\tby-argument\t-\t1\t1",
        "joy\tjoy_node\t-\t3\t1",
        "nodelet\tnodelet\timage_proc/rectify\t1\t1",
        "nodelet\tnodelet\tmanager\t1\t1",
    ]


def test_a_folder_without_a_repository_does_not_replace_the_table(
    robots: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "robots.txt"
    table.write_text("the table\n")
    monkeypatch.setattr(robots, "TABLE", table)
    monkeypatch.setattr(sys, "argv", ["robots.py", "--scan", str(tmp_path / "nope")])
    with pytest.raises(SystemExit):
        robots.main()
    assert "nope is not a git repository" in capsys.readouterr().err
    assert table.read_text() == "the table\n"


def test_which_programs_run(robots: ModuleType) -> None:
    row = robots.Row
    assert row("tf", "tf_echo", "-", 1, 1).runs and row("tf", "tf_echo", "-", 1, 1).ran_before
    assert row("tf2_tools", "echo", "-", 1, 1).runs  # its file is echo.py
    new = row("robot_state_publisher", "state_publisher", "-", 1, 1)
    assert new.runs and not new.ran_before
    assert row("nodelet", "nodelet", "topic_tools/RelayNodelet", 1, 1).runs
    assert not row("nodelet", "nodelet", "no_such_package/Thing", 1, 1).runs
    assert not row("no_such_package", "thing", "-", 1, 1).runs
