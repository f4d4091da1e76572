"""Examples that are copied: each in each of its faces, and what is said if there is none of a name."""

from __future__ import annotations

import ast
import os
import re
import sys
from pathlib import Path

import pytest
from defusedxml.ElementTree import fromstring

from pyros1.cli.main import entry
from pyros1.finding.library import Library
from pyros1.finding.manifest import read_manifest
from pyros1.guide.catalogue import (
    APIS,
    CATALOGUE,
    EXAMPLES_FOLDER,
    PACKAGE_PLACEHOLDER,
    SHARED_FOLDER_NAME,
    collect_files,
    commands_to_try,
    find_example,
)
from pyros1.guide.documents import steps

pytestmark = pytest.mark.once

COPIES = [(each.name, face) for each in CATALOGUE for face in each.apis]
NAME = "mine"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("ROS_PACKAGE_PATH", "")
    monkeypatch.delenv("CMAKE_PREFIX_PATH", raising=False)
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)
    return work


def create(*words: str) -> int:
    return entry(["pyros1", "pkg", "create", *words])


@pytest.mark.parametrize(("name", "face"), COPIES)
def test_a_copy_is_complete(folder: Path, capfd: pytest.CaptureFixture[str], name: str, face: str) -> None:
    assert create(NAME, "--example", name, "--face", face) == 0
    out, err = capfd.readouterr()
    assert not err
    package = folder / NAME
    paths = [path for path in package.rglob("*") if path.is_file()]
    assert {f"created {path.relative_to(folder).as_posix()}" for path in paths} <= {*out.splitlines()}
    for path in paths:
        text = path.read_text(encoding="utf-8")
        assert PACKAGE_PLACEHOLDER not in text and "@" not in re.sub(r"@todo|^ *@.*$", "", text, flags=re.M), path
        assert bool(path.stat().st_mode & 0o111) == text.startswith("#!"), path
        if path.suffix in (".launch", ".test", ".urdf", ".xml"):
            fromstring(text)
        if path.parent.name == "scripts":
            check_script(path, text)
    manifest = read_manifest(package / "package.xml")
    assert {*find_example(name).dependencies(face)} <= {*manifest.run_dependencies()}
    built = re.findall(r"<depend>(\w+)<", (package / "package.xml").read_text())
    assert not {"tf2_ros", "rosbag", "robot_state_publisher"} & {*built}  # which need not be there to build
    cmake = (package / "CMakeLists.txt").read_text()
    code = [line.strip() for line in cmake.splitlines() if not line.lstrip().startswith("#")]
    for path in paths:
        if path.parent.name in ("srv", "action", "cfg"):
            assert path.name in code or f"cfg/{path.name}" in code
        if path.parent.name == "scripts":
            assert f"scripts/{path.name}" in code


def check_script(path: Path, text: str) -> None:
    """It compiles, says at its top how to run it, and can be read at a glance."""
    said = ast.get_docstring(ast.parse(text)) or ""
    compile(text, path, "exec")
    assert path.name in said and (f"pyros1 run {NAME} " in said or f"pyros1 launch {NAME} " in said), path
    assert 15 <= len(text.splitlines()) <= 60, path


def test_what_is_to_be_tried_is_there() -> None:
    for name, face in COPIES:
        found = find_example(name)
        files = {Path(file).name for file in collect_files([found], face, NAME)}
        assert found.commands
        for text in [*commands_to_try([found], NAME), *found.files(face, NAME).values()]:
            for named in re.findall(rf"pyros1 (?:run|launch|test) {NAME} (\S+)", text):
                assert named in files, text


@pytest.mark.parametrize("face", APIS)
def test_examples_do_not_overwrite_each_other(face: str) -> None:
    seen: dict[str, str] = {}
    for each in CATALOGUE:
        for path, text in each.files(face, NAME).items():
            assert seen.setdefault(path, text) == text, f"{each.name}: {path}"


def test_all_folders_are_in_the_catalogue() -> None:
    assert {path.name for path in EXAMPLES_FOLDER.iterdir() if path.is_dir()} == {each.name for each in CATALOGUE}
    for each in CATALOGUE:
        parts = {path.name for path in (EXAMPLES_FOLDER / each.name).iterdir()}
        assert each.apis and parts <= {*APIS, SHARED_FOLDER_NAME}


def test_the_steps_of_the_guide_name_examples_that_there_are() -> None:
    named = {name for step in steps() for name in re.findall(r"--example (\w+)", step.text)}
    assert len(named) > 8
    for name in named:
        assert find_example(name).name == name


@pytest.mark.slow
@pytest.mark.parametrize("face", APIS)
def test_launch_files_name_what_there_is(
    folder: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, face: str
) -> None:
    # As in an activated environment: the check asks the python3 that would run the scripts.
    monkeypatch.setenv("PATH", os.pathsep.join([os.path.dirname(sys.executable), os.environ["PATH"]]))
    words = [word for each in CATALOGUE if face in each.apis for word in ("-e", each.name)]
    assert create(NAME, "--face", face, *words) == 0
    capfd.readouterr()
    files = sorted((folder / NAME).rglob("*.launch"))
    assert len(files) > 3
    for path in files:
        assert entry(["pyros1", "launch", "--check", str(path)]) == 0, capfd.readouterr()


def test_definitions_are_found_at_once(folder: Path) -> None:
    assert create(NAME, "--example", "service") == 0
    library = Library({"ROS_PACKAGE_PATH": str(folder)}, installs=[])
    assert [field.name for field in library.service(f"{NAME}/Divide").response.fields] == ["quotient"]


def test_the_list_names_each_with_a_line(capfd: pytest.CaptureFixture[str], folder: Path) -> None:
    assert create("--list-examples") == 0
    lines = capfd.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == [each.name for each in CATALOGUE]
    assert all(each.about in line for each, line in zip(CATALOGUE, lines, strict=True))
    assert not [*folder.iterdir()]


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (
            ["-e", "servce"],
            "ERROR: there is no example 'servce' (did you mean 'service'?); the examples are: ",
        ),
        (
            ["-e", "asyncio", "--face", "rospy"],
            "ERROR: the example 'asyncio' is not available with --face rospy, only with: node\n",
        ),
        (["-e", "timer", "--meta"], "ERROR: --example cannot be used here: a metapackage has no files\n"),
        (["-e", "timer", "--no-examples"], "ERROR: --example cannot be used here: --no-examples excludes it\n"),
        (["-e", "timer", "-e", "nothing"], "ERROR: there is no example 'nothing'; the examples are: "),
    ],
)
def test_errors_name_what_there_is(
    folder: Path, capfd: pytest.CaptureFixture[str], words: list[str], text: str
) -> None:
    assert create(NAME, *words) == 1
    assert capfd.readouterr().err.startswith(text)
    assert not [*folder.iterdir()]
