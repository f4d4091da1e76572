"""Packages of install and devel spaces, and of Python packages."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from pyros1.launch.places import package_index
from pyros1.launch.resources import Resources


def make(folder: Path) -> Path:
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text(f"<package><name>{folder.name}</name></package>")
    return folder


def test_package_index(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    in_space, in_share = make(tmp_path / "install" / "share" / "one"), make(tmp_path / "prefix" / "share" / "two")
    in_python = make(tmp_path / "site" / "three")
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "prefix"))
    monkeypatch.setattr("sysconfig.get_path", lambda name: str(tmp_path / "site"))
    index = package_index({"CMAKE_PREFIX_PATH": str(tmp_path / "install")})
    assert [index.find(name) for name in ("one", "two", "three")] == [in_space, in_share, in_python]


def test_find_in_a_devel_space_x70(tmp_path: Path) -> None:
    package = make(tmp_path / "src" / "mine")
    program, data = tmp_path / "devel" / "lib" / "mine" / "run", tmp_path / "devel" / "share" / "mine" / "made"
    for file in (program, data):
        file.parent.mkdir(parents=True)
        file.touch(0o755)
    (package / "run").touch(0o755)
    environ = {"ROS_PACKAGE_PATH": str(tmp_path / "src"), "CMAKE_PREFIX_PATH": str(tmp_path / "devel")}
    resources = Resources(package_index(environ), environ)
    assert resources.find("mine", "/scripts/run") == str(program)
    assert resources.find("mine", "\\made") == str(data)
    assert resources.find("mine", "/none") == f"{package}/none"
    assert resources.find("mine", "/") == resources.find("mine") == str(package)
