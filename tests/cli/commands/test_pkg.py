"""`pyros1 pkg`: verbs, making packages, and finding those around the current folder."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from pyros1.cli.main import entry
from pyros1.cli.nearby_packages import add_nearby_packages
from pyros1.finding.packages import OWN_PACKAGES, PackageIndex

SOURCE = Path(__file__).resolve().parents[3] / "src"


@pytest.fixture(autouse=True)
def clean(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("ROS_PACKAGE_PATH", "")
    monkeypatch.delenv("CMAKE_PREFIX_PATH", raising=False)
    monkeypatch.chdir(work)
    return work


def package(folder: Path, text: str = "") -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "package.xml").write_text(f"<package format='2'><name>{folder.name}</name>{text}</package>")


def pkg(*words: str) -> int:
    return entry(["pyros1", "pkg", *words])


@pytest.mark.slow
def test_created_package_is_found_and_run_from_its_folder(clean: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert pkg("create", "my_robot", "std_msgs") == 0
    said = capfd.readouterr().out
    assert "pyros1 launch my_robot minimal.launch" in said and f"ROS_PACKAGE_PATH={clean}:" in said
    assert pkg("find", "my_robot") == 0
    assert capfd.readouterr().out == f"{clean / 'my_robot'}\n"
    script = clean / "my_robot" / "scripts" / "try"
    code = "from pyros1.msgs.my_robot.msg import Measurement; print(Measurement(value=2.0).value)"
    script.write_text(f"#!{sys.executable}\n{code}\n")
    script.chmod(0o755)
    environ = {**os.environ, "PYTHONPATH": str(SOURCE), "ROS_PACKAGE_PATH": ""}
    for words, said in {
        ("msg", "show", "my_robot/Measurement"): "time stamp\nfloat64 value\n\n",
        ("run", "my_robot", "try"): "2.0\n",
        ("launch", "--nodes", "my_robot", "minimal.launch"): "/minimal_publisher\n/minimal_subscriber\n",
    }.items():
        command = [sys.executable, "-m", "pyros1", *words]
        done = subprocess.run(command, env=environ, capture_output=True, text=True, timeout=60, check=False)
        assert (done.stdout, done.stderr) == (said, "")


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        (["create", "Bad"], 1, "lower-case"),
        (["create", "ok_name", "-V", "1"], 1, "three numbers"),
        (["create", "there"], 1, "already exists"),
        (["create", "ok_name", "std_msg"], 0, "did you mean 'std_msgs'"),
        (["create", "minimal_nodes"], 0, "another package 'minimal_nodes' in"),
        (["find", "minimal_node"], 1, "did you mean 'minimal_nodes'"),
        (["finds", "x"], 1, "did you mean 'find'"),
        (["depends", "nope"], 1, "no such package nope"),
        (["-q", "depends", "nope"], 1, ""),
        (["cat", "minimal_nodes", "nope.txt"], 1, "no file nope.txt"),
        (["cd", "minimal_node"], 1, "did you mean 'minimal_nodes'"),
    ],
)
def test_errors_are_said_in_words(
    clean: Path, capsys: pytest.CaptureFixture[str], words: list[str], code: int, text: str
) -> None:
    package(clean / "there")
    assert pkg(*words) == code
    said = capsys.readouterr().err
    assert text in said if text else said == ""


def test_help_has_our_own_verbs_only_under_our_name(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert pkg("help") == 0
    ours = capsys.readouterr().out
    assert ours.startswith("USAGE: pyros1 pkg <command>") and "\n    create NAME" in ours
    assert "\n  pyros1 pkg create my_robot std_msgs  " in ours
    monkeypatch.setattr("sys.argv", ["/usr/bin/rospack"])
    assert pkg("-q", "--help") == 0
    stock = capsys.readouterr().out
    assert ours.replace("pyros1 pkg", "rospack").startswith(stock.rstrip("\n")) and "create" not in stock


def test_dependencies(clean: Path, capsys: pytest.CaptureFixture[str]) -> None:
    package(clean / "one", "<depend>two</depend><exec_depend>three</exec_depend>")
    package(clean / "two", "<depend>three</depend>")
    package(clean / "three", "<depend>one</depend>")  # a circle: every question still has an answer
    package(clean / "broken", "<depend>")
    for words, expected in {
        ("depends", "one"): "three\ntwo\n",
        ("depends1", "one"): "three\ntwo\n",
        ("depends-on", "three"): "one\ntwo\n",
        ("depends-on1", "two"): "one\n",
        ("depends-why", "--target=three", "one"): (
            "Dependency chains from one to three:\n* one -> three \n* one -> two -> three \n"
        ),
        ("list-names", "--json"): None,
    }.items():
        assert pkg(*words) == 0
        out = capsys.readouterr().out
        assert out == expected if expected is not None else {"one", "two", "three", "broken"} <= {*json.loads(out)}
    assert pkg("depends", "broken") == 1
    assert "broken/package.xml" in capsys.readouterr().err


def test_files_of_packages(clean: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    package(clean / "one")
    (clean / "one" / "config").mkdir()
    (clean / "one" / "config" / "a.yaml").write_text("a: 1\n")
    monkeypatch.setenv("ROS_LOCATIONS", f"here={clean}:x=/nowhere")
    monkeypatch.setenv("EDITOR", "head -c 1")
    for words, expected in {
        ("cd", "one/config"): f"{clean}/one/config\n",
        ("cd", "here/one"): f"{clean}/one\n",
        ("ls", "one"): "config\npackage.xml\n",
        ("cat", "one", "a.yaml"): "a: 1\n",
        ("cat", "one", "config/a.yaml"): "a: 1\n",
        ("edit", "one", "a.yaml"): "a",
    }.items():
        assert pkg(*words) == 0
        assert capfd.readouterr().out == expected
    for value, reason in {"/no/such": "not found", "'": "No closing quotation", "/": "Permission denied"}.items():
        for verb, variable in (("edit", "EDITOR"), ("cat", "CATTER")):
            monkeypatch.setenv(variable, value)
            assert pkg(verb, "one", "a.yaml") == 1
            err = capfd.readouterr().err
            assert f"program {value}: " in err and reason in err and f"set {variable} to an installed program" in err
    monkeypatch.setenv("CATTER", " ")
    assert pkg("cat", "one", "a.yaml") == 0 and capfd.readouterr().out == "a: 1\n"
    assert pkg("cp", "one", "a.yaml", "b.yaml") == 0 and Path("b.yaml").read_text() == "a: 1\n"
    assert pkg("mv", "-d", "one", "a.yaml", "one") == 0 and (clean / "one" / "a.yaml").is_file()
    assert pkg("cd", "one/nope") == 1


# Packages around the current folder -----------------------------------------------------------------------------------


def here(folder: Path, monkeypatch: pytest.MonkeyPatch, path: str = "") -> list[str]:
    monkeypatch.chdir(folder)
    environ = {"ROS_PACKAGE_PATH": path} if path else {}
    add_nearby_packages(environ)
    return [os.path.relpath(part, folder) for part in environ.get("ROS_PACKAGE_PATH", "").split(":") if part]


def test_packages_of_the_current_folder_and_those_beside_it(clean: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert here(clean, monkeypatch) == []
    package(clean / "one")
    package(clean / "two")
    (clean / "one" / "scripts").mkdir()
    (clean / "other").mkdir()
    assert here(clean, monkeypatch) == ["one", "two"]
    assert here(clean / "one", monkeypatch) == [".", "../two"]
    assert here(clean / "one" / "scripts", monkeypatch) == ["..", "../../two"]
    assert here(clean / "other", monkeypatch) == []


def test_workspaces(clean: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package(clean / "src" / "stack" / "one")
    (clean / "devel" / "lib").mkdir(parents=True)
    assert here(clean, monkeypatch) == ["src"]
    assert here(clean / "devel" / "lib", monkeypatch) == ["../../src"]
    (clean / "devel" / "lib").rmdir()
    (clean / "devel").rmdir()
    assert here(clean, monkeypatch) == []  # nothing says that this is a workspace
    package(clean / "src" / "two")
    assert here(clean, monkeypatch) == ["src/two"]


def test_what_is_set_comes_first_and_is_not_named_twice(clean: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package(clean / "one")
    assert here(clean, monkeypatch, "/set") == [os.path.relpath("/set", clean), "one"]
    assert here(clean, monkeypatch, str(clean)) == ["."]


def test_shipped_packages_come_last_in_whatever_folder(clean: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for folder in (OWN_PACKAGES, os.path.join(OWN_PACKAGES, "minimal_nodes", "scripts")):
        assert here(Path(folder), monkeypatch) == []
    package(clean / "minimal_nodes")
    for folder in (str(clean), OWN_PACKAGES, "/"):
        environ = {"ROS_PACKAGE_PATH": str(clean)}
        monkeypatch.chdir(folder)
        add_nearby_packages(environ)
        assert PackageIndex(environ).find_folder("minimal_nodes") == str(clean / "minimal_nodes")


def test_the_warning_of_two_packages_names_the_one_that_is_used(
    clean: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    first, second = clean / "first", clean / "second"
    for folder in (first, second):
        folder.mkdir()
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    monkeypatch.chdir(first)
    assert pkg("create", "minimal_nodes") == 0
    text = f"elsewhere, unless you set ROS_PACKAGE_PATH={first}:$ROS_PACKAGE_PATH\n"
    assert f"{OWN_PACKAGES}/minimal_nodes: the new one is used in this folder" in (err := capfd.readouterr().err)
    assert text in err
    monkeypatch.chdir(second)
    for path, word in ((f"{first}:{second}", "the other"), (f"{second}:{first}", "the new")):
        monkeypatch.setenv("ROS_PACKAGE_PATH", path)
        assert pkg("create", "minimal_nodes") == 0
        err = capfd.readouterr().err
        assert f"{first}/minimal_nodes: {word} one is used, because it is first in ROS_PACKAGE_PATH\n" in err
        shutil.rmtree(second / "minimal_nodes")


def test_in_a_place_for_all_only_ones_own_packages_count(clean: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package(clean / "one")
    clean.chmod(0o1777)
    assert here(clean, monkeypatch) == ["one"]
    monkeypatch.setattr("os.getuid", lambda: 4242)
    assert here(clean, monkeypatch) == []


def test_the_workspace_that_roscd_alone_means(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def cd(*words: str) -> tuple[int, str]:
        code = entry(["pyros1", "pkg", "cd", *words])
        said = capsys.readouterr()
        return code, said.out + said.err

    for name in ("plain", "devel", "workspace"):
        (tmp_path / name).mkdir()
    (tmp_path / "devel" / ".catkin").touch()
    for name in ("ROS_WORKSPACE", "CMAKE_PREFIX_PATH", "ROS_PACKAGE_PATH"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.chdir(tmp_path)
    code, said = cd()
    assert code == 1 and "source the setup.bash of a workspace" in said
    monkeypatch.setenv("CMAKE_PREFIX_PATH", str(tmp_path / "plain"))
    assert cd()[0] == 1
    monkeypatch.setenv("CMAKE_PREFIX_PATH", f"{tmp_path / 'plain'}:{tmp_path / 'devel'}")
    assert cd() == (0, f"{tmp_path / 'devel'}\n")
    monkeypatch.setenv("ROS_WORKSPACE", str(tmp_path / "workspace"))
    assert cd() == (0, f"{tmp_path / 'workspace'}\n")
    assert cd("--help") == cd("a", "b") == (1, "roscd: usage: roscd [package[/folder]]\n")


@pytest.mark.parametrize(("words", "code"), [(["profile"], 0), (["find", "roscpp"], 1), ([], 1)])
def test_rosstack_says_what_to_use_l183(words: list[str], code: int, capfd: pytest.CaptureFixture[str]) -> None:
    """READMEs have ``rospack profile && rosstack profile``, which must go on."""
    assert entry(["pyros1", "rosstack", *words]) == code
    out, err = capfd.readouterr()
    assert out == "" and err == "rosstack: stacks belong to rosbuild; for packages, use rospack, which is pyros1 pkg\n"
    assert entry(["pyros1", "stack", *words]) == 64
    assert "did you mean 'pkg'?" in capfd.readouterr().err
