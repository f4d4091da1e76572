"""Which commands of launch files run programs of pyros1."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from pyros1.finding.packages import OWN_PACKAGES
from pyros1.launch.reading.own_commands import own_environment, own_words
from pyros1.launch.reading.system_resources import run_command

XACRO = [sys.executable, "-m", "pyros1.launch.reading.xacro_tool"]


def test_words(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_PACKAGE_PATH", OWN_PACKAGES)
    monkeypatch.setenv("PATH", str(tmp_path))
    for name in ("xacro", "xacro.py"):
        assert own_words(["rosrun", "xacro", name, "a"]) == [*XACRO, "a"]
    assert own_words(["rosrun", "xacro"]) == [sys.executable, "-m", "pyros1", "rosrun", "xacro"]
    assert own_words(["rosversion", "-d"]) == [sys.executable, "-m", "pyros1", "rosversion", "-d"]
    assert own_words(["rosdance"]) == ["rosdance"]
    assert own_words([]) == []
    for name in ("rosrun", "rosversion"):
        (tmp_path / name).write_text("#!/bin/sh\n")
        (tmp_path / name).chmod(0o755)
    assert own_words(["rosversion", "-d"]) == ["rosversion", "-d"], "the installed one"
    assert own_words(["rosrun", "xacro", "xacro", "a"]) == [*XACRO, "a"], "which would not find pyros1's xacro"
    package = tmp_path / "xacro"
    package.mkdir()
    (package / "package.xml").write_text("<package><name>xacro</name></package>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    assert own_words(["rosrun", "xacro", "xacro", "a"]) == ["rosrun", "xacro", "xacro", "a"], "another xacro"


def test_tools_that_are_not_installed_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert run_command(["rosversion", "rospy"]).startswith("1.")


@pytest.mark.skipif(os.name == "nt", reason="a shell script")
def test_wrappers_find_this_python(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first line of a package's programs is ``#!/usr/bin/env python3``, and a wrapper runs them."""
    wrapper = tmp_path / "env_run"
    wrapper.write_text('#!/bin/sh\nshift\nexec "$@"\n')
    wrapper.chmod(0o755)
    monkeypatch.setenv("PATH", "/usr/bin:/bin")
    monkeypatch.delenv("PYTHONPATH", raising=False)
    urdf = tmp_path / "robot.xacro"
    urdf.write_text('<robot name="r"/>')
    assert 'name="r"' in run_command(
        [str(wrapper), "settings", os.path.join(OWN_PACKAGES, "xacro", "xacro"), str(urdf)]
    )
    assert own_environment([str(wrapper), "x"], os.environ) is None
    environment = own_environment(["x", f"{OWN_PACKAGES}/xacro/xacro"], {"PATH": "/bin"})
    assert environment is not None
    assert environment["PATH"] == f"{os.path.dirname(sys.executable)}{os.pathsep}/bin"
