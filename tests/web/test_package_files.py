"""Files of packages, and what attackers ask for."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from pyros1.finding.packages import PackageIndex
from pyros1.web.package_files import FileError, PackageFiles


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    """A package ``arm``, with a secret file beside it."""
    folder = tmp_path / "src" / "arm"
    (folder / "meshes").mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>arm</name></package>")
    (folder / "meshes" / "upper arm.stl").write_bytes(b"solid")
    (tmp_path / "secret").write_text("secret")
    return folder


@pytest.fixture
def files(tmp_path: Path, arm: Path) -> PackageFiles:
    """The files of ``arm``."""
    environ = {"ROS_PACKAGE_PATH": str(tmp_path / "src")}
    return PackageFiles(lambda: PackageIndex(environ, installs=()), max_size=1000)


def test_a_mesh(files: PackageFiles) -> None:
    assert files.read("package://arm/meshes/upper%20arm.stl") == b"solid"
    assert files.read("package://arm//meshes/./upper arm.stl") == b"solid"


def test_a_file_by_its_path(files: PackageFiles, arm: Path, tmp_path: Path) -> None:
    assert files.read(f"file://{arm}/meshes/upper%20arm.stl") == b"solid"
    twin = tmp_path / "elsewhere" / "arm"  # not the package that is found by its name
    twin.mkdir(parents=True)
    (twin / "package.xml").write_text("<package><name>arm</name></package>")
    (twin / "a.stl").write_bytes(b"1")
    (arm / "out.stl").symlink_to(tmp_path / "secret")
    for path in (twin / "a.stl", tmp_path / "secret", arm / ".." / ".." / "secret", arm / "out.stl"):
        with pytest.raises(FileError, match=r"not in a package|does not refer to a file"):
            files.read(f"file://{path}")
    with pytest.raises(FileError):
        files.read(f"file://localhost{arm}/meshes/upper%20arm.stl")


def test_links_within_a_package(files: PackageFiles, arm: Path) -> None:
    (arm / "link.stl").symlink_to(arm / "meshes" / "upper arm.stl")
    assert files.read("package://arm/link.stl") == b"solid"


@pytest.mark.parametrize(
    "uri",
    [
        "",
        "arm/meshes",
        "file:///etc/passwd",
        "http://localhost/",
        "package://",
        "package:///etc/passwd",
        "package://arm",
        "package://arm/",
        "package://arm/meshes",
        "package://arm/none.stl",
        "package://arm/../secret",
        "package://arm/../../secret",
        "package://arm/%2e%2e/%2e%2e/secret",
        "package://arm/meshes/..%2f..%2f..%2fsecret",
        "package://arm/..\\..\\secret",
        "package://../secret",
        "package://./secret",
        "package://arm/%00",
        "package://arm/meshes/upper%20arm.stl%00.png",
        "package://[/x",
        "package://arm/" + "a" * 5000,
        "package://arm/" + "a" * 500,
        "package://none/x",
        "package://arm/\ud800",
    ],
    ids=range(24),
)
def test_nothing_else_is_read(files: PackageFiles, uri: str) -> None:
    with pytest.raises(FileError):
        files.read(uri)


def test_links_that_lead_out_are_not_followed(files: PackageFiles, arm: Path, tmp_path: Path) -> None:
    (arm / "out").symlink_to(tmp_path / "secret")
    (arm / "up").symlink_to(tmp_path)
    for uri in ("package://arm/out", "package://arm/up/secret"):
        with pytest.raises(FileError, match="leads out"):
            files.read(uri)


def test_links_that_lead_to_each_other(files: PackageFiles, arm: Path) -> None:
    (arm / "loop").symlink_to("loop")
    for uri in (f"file://{arm}/loop", f"file://{arm}/loop/a.stl", "package://arm/loop", "package://arm/loop/a.stl"):
        with pytest.raises(FileError, match="cannot be"):
            files.read(uri)


def test_large_files_and_pipes(files: PackageFiles, arm: Path) -> None:
    (arm / "large").write_bytes(bytes(1001))
    with pytest.raises(FileError, match="1001 bytes; the limit is 1000"):
        files.read("package://arm/large")
    os.mkfifo(arm / "pipe")
    with pytest.raises(FileError, match="not a file"):
        files.read("package://arm/pipe")


def test_a_package_that_comes_later(files: PackageFiles, tmp_path: Path) -> None:
    with pytest.raises(FileError, match="no package leg"):
        files.read("package://leg/x")
    leg = tmp_path / "src" / "leg"
    leg.mkdir()
    (leg / "package.xml").write_text("<package><name>leg</name></package>")
    (leg / "x").write_bytes(b"1")
    assert files.read("package://leg/x") == b"1"


def test_packages_are_not_searched_for_again_and_again(tmp_path: Path, arm: Path) -> None:
    made: list[PackageIndex] = []
    now = 0.0

    def make() -> PackageIndex:
        made.append(PackageIndex({"ROS_PACKAGE_PATH": str(tmp_path / "src")}, installs=()))
        return made[-1]

    files = PackageFiles(make, clock=lambda: now)
    for _ in range(3):
        with pytest.raises(FileError, match="no package leg"):
            files.read("package://leg/meshes/leg.stl")
        assert files.read("package://arm/meshes/upper%20arm.stl") == b"solid"
    assert len(made) == 1
    leg = tmp_path / "src" / "deep" / "leg"
    leg.mkdir(parents=True)
    (leg / "package.xml").write_text("<package><name>leg</name></package>")
    (leg / "leg.stl").write_bytes(b"leg")
    now = 60.0
    assert files.read("package://leg/leg.stl") == b"leg"
    assert len(made) == 2
