"""Packages whose folders are links to elsewhere: stock roslaunch, rosrun, rosmsg and ours find the same in them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from harness import SOURCE

pytestmark = pytest.mark.ours_only

LINES = [
    ("roslaunch", "launch", "--files linked x.launch"),
    ("roslaunch", "launch", "--nodes linked x.launch"),
    ("roslaunch", "launch", "--args /n linked x.launch"),
    ("roslaunch", "launch", "--files linked nope.launch"),
    ("rosrun", "run", "linked tool"),
    ("rosrun", "run", "linked bin/tool"),
    ("rosmsg", "msg", "show linked/Value"),
    ("rosmsg", "msg", "package linked"),
    ("rospack", "pkg", "find linked"),
    ("rospack", "pkg", "find behind"),
]


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A workspace; no link in it leads back, in which stock roslaunch would walk for minutes."""
    top = tmp_path_factory.mktemp("linked")
    for name in ("src/linked", "elsewhere/pkg/behind"):
        (top / name).mkdir(parents=True)
        tags = f"<name>{Path(name).name}</name><version>1.0.0</version><description>d</description><license>x</license>"
        text = f'<package>{tags}<maintainer email="a@b.c">m</maintainer></package>'
        (top / name / "package.xml").write_text(text)
    files = {
        "launch/deep/x.launch": '<launch><node name="n" pkg="linked" type="tool"/></launch>',
        "bin/tool": "#!/bin/sh\necho ran\n",
        "msg/Value.msg": "int32 value\n",
    }
    for name, text in files.items():
        path = top / "elsewhere" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)
    for name in ("launch", "bin", "msg"):
        (top / "src/linked" / name).symlink_to(top / "elsewhere" / name)
    (top / "src/linked/nowhere").symlink_to("/nowhere")
    (top / "src/packages").symlink_to(top / "elsewhere/pkg")
    return top


@pytest.mark.parametrize(("tool", "command", "words"), LINES, ids=lambda value: value)
def test_the_same_is_found(workspace: Path, tool: str, command: str, words: str) -> None:
    environ = {
        **os.environ,
        "PATH": f"/usr/bin:{os.environ['PATH']}",
        "ROS_PACKAGE_PATH": f"{workspace / 'src'}:/usr/share",
        "ROS_HOME": str(workspace / "home"),
        "PYTHONPATH": "",
        "XDG_CACHE_HOME": str(workspace / "cache"),
    }

    def ask(*line: str, **more: str) -> tuple[int, str]:
        done = subprocess.run(
            line, capture_output=True, text=True, timeout=60, check=False, cwd=workspace, env={**environ, **more}
        )
        return done.returncode, done.stdout

    mine = ask(sys.executable, "-m", "pyros1", command, *words.split(), PYTHONPATH=str(SOURCE))
    assert mine == ask(tool, *words.split())
