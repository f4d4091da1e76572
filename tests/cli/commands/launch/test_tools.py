"""The tools beside the launcher: needs, logs, arguments, results of checks (L174, L175)."""

from __future__ import annotations

import os
import subprocess
import sys
import xml.etree.ElementTree
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

from pyros1.cli.main import entry

pytestmark = pytest.mark.once

SOURCES = Path(__file__).resolve().parents[4] / "src"
PACKAGE = """<package format="2"><name>mine</name><version>1.0.0</version><description>d</description>
<maintainer email="a@example.org">a</maintainer><license>BSD</license>
<exec_depend>minimal_nodes</exec_depend><test_depend>tester</test_depend></package>"""
FILES = {
    "package.xml": PACKAGE,
    "launch/good.launch": '<launch><arg name="b" default="1"/><arg name="a"/>'
    '<node pkg="minimal_nodes" type="minimal_publisher" name="n"/></launch>',
    "launch/more.launch": '<launch><include file="$(dirname)/good.launch"/><param name="p" command="no_such"/>'
    '<param name="t" textfile="/no/such"/><node pkg="other" type="x" name="n2"/></launch>',
    "launch/misspelt.launch": '<launch><node pkg="minimal_nodes" type="minimal_publsher" name="n"/></launch>',
    "launch/needs.launch": '<launch><arg name="a"/><param name="p" value="$(arg a)$(env SET_HERE)"/></launch>',
    "good/deep/a.launch": "<launch/>",
    "good/b.launch": "<launch/>",
    "good/not.xml": "<no",
}


class Answer(NamedTuple):
    """What a command said."""

    code: int
    out: str
    err: str


Ask = Callable[..., Answer]


@pytest.fixture
def ask(tmp_path: Path) -> Ask:
    place = tmp_path / "mine"
    for path, text in FILES.items():
        (place / path).parent.mkdir(parents=True, exist_ok=True)
        (place / path).write_text(text)
    env = {
        **os.environ,
        "PYTHONPATH": str(SOURCES),
        "ROS_PACKAGE_PATH": str(place),
        "ROS_HOME": str(tmp_path / "home"),
        "ROS_MASTER_URI": "http://localhost:1",
    }
    env.pop("ROS_LOG_DIR", None)

    def ask(*words: str, cwd: Path = place) -> Answer:
        command = [sys.executable, "-m", "pyros1", "launch", *words]
        done = subprocess.run(command, cwd=cwd, env=env, capture_output=True, text=True, timeout=60, check=False)
        return Answer(done.returncode, done.stdout, done.stderr)

    return ask


@pytest.mark.slow
def test_needs_of_files_l175(ask: Ask) -> None:
    assert ask("--deps", "launch/good.launch") == (0, "minimal_nodes\n", "")
    code, out, _ = ask("--deps", "-v", "-w", "launch/more.launch")
    assert code == 0
    assert out.splitlines() == [
        "processing launch launch/more.launch",
        f"processing included launch {Path(ask('--files', 'launch/good.launch').out.strip())}",
        "Dependencies:",
        "other [other/x]",
        "mine [launch/more.launch]",
        "minimal_nodes [minimal_nodes/minimal_publisher]",
        f"mine [{Path(ask('--files', 'launch/good.launch').out.strip())}]",
        "-" * 80,
        "minimal_nodes other",
        "",
        "Missing declarations:",
        "mine/manifest.xml:",
        '  <depend package="other" />',
    ]
    assert ask("--deps", "launch/good.launch", "launch/misspelt.launch")[:2] == (0, "minimal_nodes\n")
    assert ask("--deps", "launch/needs.launch").code == 1
    assert ask("--deps", "no_such.launch").code == 2
    assert ask("--deps").code == 2
    code, _, err = ask("launch/good.launch", "--deps")
    assert code == 2 and "--deps must be the first argument" in err


@pytest.mark.slow
def test_arguments_for_shells_l175(ask: Ask) -> None:
    assert ask("--complete", "launch/good.launch") == (0, "a b\n", "")
    assert ask("--complete", "mine", "good.launch", "b:=2") == (0, "a b\n", "")
    assert ask("--complete", "no_such.launch") == (1, "", "")
    assert ask("--complete") == (0, "\n", "")


@pytest.mark.slow
def test_logs_without_a_master_l175(ask: Ask, tmp_path: Path) -> None:
    assert ask("--logs") == (2, f"{tmp_path}/home/log\n", "No active roscore\n")
    assert ask("--logs", "word").code == 2


@pytest.mark.slow
def test_results_of_a_check_l174(ask: Ask, tmp_path: Path) -> None:
    results = tmp_path / "results" / "r.xml"
    code, out, err = ask("--check", "-o", str(results), "launch/good.launch")
    assert (code, err) == (0, "")
    assert out == f"checking launch/good.launch\n...writing test results to {results}\npassed\n"
    suite = xml.etree.ElementTree.parse(results).getroot()
    assert (suite.get("name"), suite.get("failures"), suite.get("tests")) == ("r.xml", "0", "1")
    assert suite[0].get("name") == "mine_launch_good_launch"
    code, out, err = ask("--check", f"--output-file={results}", "launch")
    assert code == 1 and err.startswith("FAILURE:\n")
    assert "Missing package dependencies: mine/package.xml: other" in err
    assert "(did you mean 'minimal_publisher'?)" in err
    failure = xml.etree.ElementTree.parse(results).getroot().find("testcase/failure")
    assert failure is not None and "[launch/misspelt.launch]" in (failure.text or "")
    assert "[launch/good.launch]" not in (failure.text or "")


@pytest.mark.slow
def test_a_folder_is_checked_with_all_below_l174(ask: Ask) -> None:
    code, out, err = ask("--check", "good")
    assert (code, err) == (0, "")
    lines = ["checking *.launch in directory good", "checking good/b.launch", "checking good/deep/a.launch", "passed"]
    assert out.splitlines() == lines


@pytest.mark.slow
def test_a_file_of_a_package_that_lies_here_is_checked_x05(ask: Ask, tmp_path: Path) -> None:
    code, out, err = ask("--check", "mine", "good.launch", cwd=tmp_path)
    assert (code, out, err) == (0, "no problems: 1 file, 1 node, 0 parameters\n", "")
    assert ask("--check", "mine", "absent.launch", cwd=tmp_path).code == 1
    assert ask("--check", "mine/good", "SET_HERE=1", cwd=tmp_path).out.endswith("passed\n")


@pytest.mark.slow
def test_programs_in_python_are_read_but_not_executed(ask: Ask, tmp_path: Path) -> None:
    for name, text in (("old", "print 'a'\n"), ("lacking", "import nothing_of_that_name\nopen('here', 'w')\n")):
        script = tmp_path / "mine" / "scripts" / name
        script.parent.mkdir(exist_ok=True)
        script.write_text(f"#!{sys.executable}\n{text}")
        script.chmod(0o755)
    nodes = "".join(f'<node pkg="mine" type="{name}" name="{name}"/>' for name in ("old", "lacking"))
    (tmp_path / "mine" / "launch" / "python.launch").write_text(f"<launch>{nodes}</launch>")
    code, out, _ = ask("--check", "launch/python.launch")
    assert code == 1 and len(out.splitlines()) == 2
    assert f"node [/old]: it cannot run: {tmp_path}/mine/scripts/old:2: Missing parentheses" in out
    assert (
        f"node [/lacking]: it cannot run: {tmp_path}/mine/scripts/lacking:2: {sys.executable} cannot find module" in out
    )
    assert ask("--check", "-o", "r.xml", "launch/python.launch").code == 1
    assert not (tmp_path / "mine" / "here").exists()


def test_the_check_under_its_stock_name_l174(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], ask: Ask, tmp_path: Path
) -> None:
    """As the programs that `pyros1 setup` makes run it."""
    monkeypatch.chdir(tmp_path / "mine")
    monkeypatch.setattr("sys.argv", ["/somewhere/roslaunch-check"])

    def check(*words: str) -> Answer:
        try:
            code = entry(["pyros1", "launch", "--check", *words])
        except SystemExit as end:
            code = int(str(end.code))
        return Answer(code, *capsys.readouterr())

    code, out, _ = check("-h")
    assert code == 0 and out.startswith("Usage: roslaunch-check [options] <file|folder>")
    assert all(option in out for option in ("-o FILE", "-t, --use-test-depends", "-i, --ignore-unset-args"))
    assert "pyros1 launch" not in out
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "mine"))
    assert check("-i", "launch/needs.launch", "SET_HERE=1") == (0, "checking launch/needs.launch\npassed\n", "")
    assert check("launch/needs.launch", "SET_HERE=1", "a:=2").code == 0
    assert check("launch/needs.launch").code == 1 and check().code == check("no/such").code == 2


@pytest.mark.slow
def test_what_a_check_can_be_told_l174(ask: Ask) -> None:
    file = "launch/needs.launch"
    assert ask("--check", "-o", "r.xml", file).code == 1
    assert ask("--check", "-o", "r.xml", file, "SET_HERE=1", "a:=2").code == 0
    assert ask("--check", "-o", "r.xml", file, "SET_HERE=1").code == 1
    assert ask("--check", "-o", "r.xml", file, "SET_HERE=1", "--ignore-unset-args").code == 0
