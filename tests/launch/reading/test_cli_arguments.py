"""launch.reading.cli_arguments: which launch files and arguments a command line names (X01, X03, X05)."""

from __future__ import annotations

from pathlib import Path

import pytest

from pyros1.finding.packages import OWN_PACKAGES, PackageIndex
from pyros1.ground.errors import LaunchError
from pyros1.launch.reading.cli_arguments import CommandLineError, find_launch_files, parse_arguments
from pyros1.launch.reading.resources import Resources

PACKAGE = """<package format="2"><name>robot</name><version>1.0.0</version><description>A node.</description>
<maintainer email="a@example.org">a</maintainer><license>BSD</license></package>"""


@pytest.fixture
def resources(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Resources:
    """A package with the launch files up.launch and base.launch, and one named twice.launch in each of two folders."""
    package = tmp_path / "robot"
    for name in ("launch/up.launch", "launch/base.launch", "a/twice.launch", "b/twice.launch", ".hidden/x.launch"):
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_text("<launch/>")
    (package / "package.xml").write_text(PACKAGE)
    (tmp_path / "empty").mkdir()
    (tmp_path / "empty" / "package.xml").write_text(PACKAGE.replace("robot", "empty"))
    (tmp_path / "here.launch").write_text("<launch/>")
    monkeypatch.chdir(tmp_path)
    environ = {"ROS_PACKAGE_PATH": f"{package}:{tmp_path / 'empty'}"}
    return Resources(PackageIndex(environ), environ)


def test_files_by_package_and_by_path(resources: Resources, tmp_path: Path) -> None:
    up = str(tmp_path / "robot" / "launch" / "up.launch")
    assert find_launch_files(["robot", "up.launch"], resources) == [up]
    assert find_launch_files(["robot", "up.launch", "here.launch"], resources) == [up, "here.launch"]
    assert find_launch_files(["here.launch", up], resources) == ["here.launch", up]
    assert find_launch_files(["-"], resources) == ["-"]
    assert find_launch_files(["-", "here.launch"], resources) == ["-", "here.launch"]


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["robot", "twice.launch"], r"multiple files named \[twice.launch\] in package \[robot\]:\n \* .*\n \* "),
        (
            ["robot", "down.launch"],
            r"neither a launch file in package.*has base.launch, twice.launch, up.launch",
        ),
        (["robto", "up.launch"], r"package \[robto\] not found.*did you mean 'robot'"),
        (["empty", "up.launch"], r"package \[empty\] has no launch files"),
        (["nowhere.launch"], r"\[nowhere.launch\] is not a launch file name"),
        (["robot"], r"\[robot\] is not a launch file name.*has base.launch, twice.launch, up.launch"),
        (["here.launch", "gone.launch"], "The following input files do not exist: gone.launch"),
        (["-", "-"], "Only a single instance of the dash"),
    ],
)
def test_words_that_name_no_file(resources: Resources, words: list[str], reason: str) -> None:
    with pytest.raises(LaunchError, match=reason) as caught:
        find_launch_files(words, resources)
    assert isinstance(caught.value, CommandLineError) == reason.startswith(("The following", "Only"))


def test_launch_files_of_pyros1_need_no_package(resources: Resources) -> None:
    (name, path), *_ = sorted((path.name, path) for path in Path(OWN_PACKAGES).glob("*/launch/*.launch"))
    assert find_launch_files([name], resources) == [str(path)]


def test_arguments(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["a:=1", "b:=", "_c:=3", "__d:=4", "_:=5", "x y:=6", "e:= 7 ", "f", "1g:=8", "/h/i:=9", "~j:=10", "k:=l:=m"]
    assert parse_arguments(words) == {"a": "1", "__d": "4", "_": "5", "e": "7", "/h/i": "9", "~j": "10"}
    assert capsys.readouterr().err == "ERROR: Invalid remapping argument 'k:=l:=m'\n"
