"""What ``$(find)`` means in devel spaces."""

from __future__ import annotations

from pathlib import Path

from pyros1.finding.packages import PackageIndex
from pyros1.launch.reading.resources import Resources


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
