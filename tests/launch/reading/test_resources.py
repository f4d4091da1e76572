"""What ``$(find)`` means in devel spaces."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from pyros1.finding.packages import PackageIndex
from pyros1.ground.errors import LaunchError
from pyros1.launch.reading.loader import load_plan
from pyros1.launch.reading.resources import Resources
from pyros1.launch.reading.system_resources import make_resources, run_command


def make(folder: Path) -> Path:
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text(f"<package><name>{folder.name}</name></package>")
    return folder


def test_find_in_a_devel_space_x70(tmp_path: Path) -> None:
    package = make(tmp_path / "src" / "mine")
    program, data = tmp_path / "devel" / "lib" / "mine" / "run", tmp_path / "devel" / "share" / "mine" / "made"
    for file in (program, data):
        file.parent.mkdir(parents=True)
        file.touch(0o755)
    (package / "run").touch(0o755)
    environ = {"ROS_PACKAGE_PATH": str(tmp_path / "src"), "CMAKE_PREFIX_PATH": str(tmp_path / "devel")}
    resources = Resources(PackageIndex(environ), environ)
    assert resources.find("mine", "/scripts/run") == str(program)
    assert resources.find("mine", "\\made") == str(data)
    assert resources.find("mine", "/none") == f"{package}/none"
    assert resources.find("mine", "/") == resources.find("mine") == str(package)


@pytest.mark.skipif(not os.path.exists("/dev/zero"), reason="no such device")
@pytest.mark.parametrize("source", ["textfile='/dev/zero'", "binfile='/dev/zero'", "command='cat /dev/zero'"])
def test_what_never_ends_is_an_error_that_names_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, source: str
) -> None:
    monkeypatch.setattr("pyros1.launch.reading.resources.MAX_FILE_SIZE", 3 << 20)
    file = tmp_path / "x.launch"
    file.write_text(f"<launch>\n<param name='p' {source}/></launch>")
    with pytest.raises(LaunchError, match=r"/dev/zero.* is larger than 3 MiB") as raised:
        load_plan([str(file)], {}, make_resources())
    assert raised.value.line == 2


def test_a_command_that_takes_too_long_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.launch.reading.system_resources.COMMAND_TIMEOUT_S", 0.05)
    with pytest.raises(LaunchError, match=r"did not exit within 0.05 seconds"):
        run_command([sys.executable, "-c", "input()"] if os.name == "nt" else ["sleep", "60"])
