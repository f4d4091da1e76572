"""New packages: what is written, and what is refused."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from pyros1.finding.create import CreateError, NewPackage, create_package, package_name_problem
from pyros1.finding.library import Library
from pyros1.finding.manifest import ManifestError, read_manifest


@pytest.mark.parametrize("name", ["ab", "my_robot", "robot2", "a_1_b"])
def test_good_names(name: str) -> None:
    assert package_name_problem(name) == ""


@pytest.mark.parametrize(
    "name", ["", "a", "My_robot", "my-robot", "2robots", "_a", "a__b", "a_", "class", "ö_b", "a b"]
)
def test_bad_names(name: str) -> None:
    assert package_name_problem(name)


def test_the_rule_for_names_is_not_two_letters() -> None:
    assert package_name_problem("r2") == "" and "single underscores, two characters or more" in package_name_problem(
        "R2"
    )


def test_package_with_examples(tmp_path: Path) -> None:
    person = "A <a@b.org>"
    new = NewPackage(
        "my_robot", ["std_msgs"], system_depends=["python3-numpy"], licenses=["BSD & more"], maintainers=[person]
    )
    made = create_package(new, tmp_path)
    assert {"my_robot/package.xml", "my_robot/scripts/minimal_publisher", "my_robot/launch/minimal.launch"} <= {*made}
    manifest = read_manifest(tmp_path / "my_robot" / "package.xml")
    assert (manifest.name, manifest.version) == ("my_robot", "0.0.0")
    assert manifest.run_dependencies() == ["message_runtime", "python3-numpy", "std_msgs"]
    library = Library({"ROS_PACKAGE_PATH": str(tmp_path)}, installs=[])
    assert [field.name for field in library.message("my_robot/Measurement").fields] == ["stamp", "value"]
    for name in made:
        path = tmp_path / name
        assert "@" not in path.read_text().replace("a@b.org", "")
        assert bool(path.stat().st_mode & 0o111) == ("scripts" in path.parts)


def test_bare_package_and_metapackage(tmp_path: Path) -> None:
    assert create_package(NewPackage("bare", ["roscpp"], examples=False), tmp_path) == [
        "bare/package.xml",
        "bare/CMakeLists.txt",
        "bare/include/bare/",
        "bare/src/",
    ]
    create_package(NewPackage("all_of_it", ["bare"], is_meta=True), tmp_path)
    manifest = read_manifest(tmp_path / "all_of_it" / "package.xml")
    assert manifest.is_metapackage and manifest.run_dependencies() == ["bare"]


def test_the_places_that_tutorials_name_are_there_to_be_uncommented(tmp_path: Path) -> None:
    create_package(NewPackage("plain", ["roscpp", "std_msgs"], examples=False), tmp_path)
    create_package(NewPackage("rich", ["std_msgs"]), tmp_path)
    text = (tmp_path / "plain" / "CMakeLists.txt").read_text()
    code = "".join(line for line in text.splitlines(keepends=True) if not line.lstrip().startswith("#"))
    for call in (
        *("add_message_files(", "add_service_files(", "add_action_files(", "generate_messages(", "add_library("),
        *("add_executable(", "target_link_libraries(", "add_dependencies(", "catkin_install_python(", "install("),
    ):
        assert f"\n# {call}" in text and call not in code
    assert "find_package(catkin REQUIRED COMPONENTS\n  roscpp\n  std_msgs\n)" in code
    assert "\n  # message_runtime\n" in text and "CATKIN_DEPENDS roscpp std_msgs\n" in code
    assert "-DPYTHON_EXECUTABLE=/usr/bin/python3" in text
    assert "<!-- <build_depend>message_generation</build_depend> -->" in (tmp_path / "plain/package.xml").read_text()
    rich = (tmp_path / "rich" / "CMakeLists.txt").read_text()
    assert "\nadd_message_files(\n  FILES\n  Measurement.msg\n)" in rich and "\n# add_service_files(" in rich
    assert read_manifest(tmp_path / "plain/package.xml").run_dependencies() == ["roscpp", "std_msgs"]


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "README.md").write_text("mine")
    with pytest.raises(CreateError, match=r"README\.md already exists"):
        create_package(NewPackage("mine"), tmp_path)
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["README.md"]


@pytest.mark.parametrize(
    ("new", "text"),
    [
        (NewPackage("../out"), "not a valid package name"),
        (NewPackage("ok_name", version="1.0"), "three numbers"),
    ],
)
def test_what_cannot_be_made(tmp_path: Path, new: NewPackage, text: str) -> None:
    with pytest.raises(CreateError, match=text):
        create_package(new, tmp_path)
    assert not [*tmp_path.iterdir()]


def test_a_full_disk_is_reported_with_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def write_some(path: Path, text: str, encoding: str) -> None:
        path.write_bytes(text.encode()[:9])
        if path.name == "minimal_subscriber":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))  # without a file name, as from a write

    new = NewPackage("mine", examples=True)
    (tmp_path / "mine" / "launch").mkdir(parents=True)
    with (
        monkeypatch.context() as patch,
        pytest.raises(CreateError, match=r"cannot write \S+minimal_subscriber: No space left"),
    ):
        patch.setattr(Path, "write_text", write_some)
        create_package(new, tmp_path)
    assert [*tmp_path.rglob("*")] == [tmp_path / "mine", tmp_path / "mine" / "launch"], "a part of the package is left"
    create_package(new, tmp_path)


@pytest.mark.parametrize("text", ["", "<package", "<robot/>", '<!DOCTYPE a [<!ENTITY b "c">]><package>&b;</package>'])
def test_manifests_that_cannot_be_read_are_named(tmp_path: Path, text: str) -> None:
    (tmp_path / "package.xml").write_text(text)
    with pytest.raises(ManifestError, match=r"package\.xml"):
        read_manifest(tmp_path / "package.xml")
