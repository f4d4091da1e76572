"""Which xacro runs, and that it finds packages as launch files do (X40)."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from pyros1.finding.packages import OWN_PACKAGES
from pyros1.launch.reading.xacro_tool import MISSING_MESSAGE, missing_input, xacro_words

SOURCE = Path(__file__).resolve().parents[3] / "src"
# The real one asks for packages in this way.
STAND_IN = """
import sys

def main():
    from ament_index_python.packages import get_package_share_directory
    print(*sys.argv[1:], get_package_share_directory("robot"))
"""


def test_words(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own = os.path.join(OWN_PACKAGES, "xacro")
    run = [sys.executable, "-m", "pyros1.launch.reading.xacro_tool"]
    assert xacro_words([f"{own}/xacro", "a", "b"]) == [*run, "a", "b"]
    assert xacro_words([f"{own}/xacro.py"]) == run
    assert xacro_words(["/opt/ros/lib/xacro/xacro", "a"]) == ["/opt/ros/lib/xacro/xacro", "a"]
    assert xacro_words(["cat", "a"]) == ["cat", "a"]
    assert xacro_words([]) == []
    monkeypatch.setenv("PATH", str(tmp_path))
    assert xacro_words(["xacro", "a"]) == [*run, "a"]
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert xacro_words(["xacro", "a"]) == [*run, "a"], "which says what is missing"
    (tmp_path / "xacro").write_text("#!/bin/sh\n")
    (tmp_path / "xacro").chmod(0o755)
    assert xacro_words(["xacro", "a"]) == ["xacro", "a"]


def ask(tmp_path: Path, file: str) -> subprocess.CompletedProcess[str]:
    (tmp_path / "x.launch").write_text(f'<launch><param name="p" command="{file}" /></launch>')
    env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path / "python"), str(SOURCE)])}
    words = [sys.executable, "-m", "pyros1", "launch", "--dump-params", "x.launch"]
    env["ROS_PACKAGE_PATH"] = str(tmp_path / "ws")
    return subprocess.run(words, cwd=tmp_path, env=env, capture_output=True, text=True, timeout=60, check=False)


@pytest.mark.parametrize("command", ["$(find xacro)/xacro", "$(find xacro)/xacro.py", "xacro"])
def test_packages_are_found(tmp_path: Path, command: str) -> None:
    package = tmp_path / "ws" / "robot"
    (tmp_path / "python" / "xacro").mkdir(parents=True)
    (tmp_path / "python" / "xacro" / "__init__.py").write_text(STAND_IN)
    package.mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>robot</name></package>")
    done = ask(tmp_path, f"{command} n:=5")
    assert f"n:=5 {package}" in done.stdout, done.stderr


def test_without_it_the_error_says_what_to_install(tmp_path: Path) -> None:
    broken = tmp_path / "python" / "xacro"
    broken.mkdir(parents=True)
    (broken / "__init__.py").write_text("raise ImportError")
    done = ask(tmp_path, "$(find xacro)/xacro a.xacro")
    assert MISSING_MESSAGE in done.stderr


def test_a_file_that_is_not_there_is_said_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "python" / "xacro").mkdir(parents=True)
    (tmp_path / "python" / "xacro" / "__init__.py").write_text("def main():\n    raise OSError('a traceback')\n")
    said = ask(tmp_path, "xacro gone.xacro n:=5").stderr
    assert said.startswith("xacro: no such file: gone.xacro\nUnable to load file") and said.count("\n") == 2


def test_which_file_is_missing(tmp_path: Path) -> None:
    there, gone = str(tmp_path), str(tmp_path / "gone")
    assert missing_input([there]) == missing_input([]) == missing_input([gone, gone]) == ""
    assert missing_input(["-o", there, "--verbosity", "1", gone, "a:=b", "--inorder"]) == gone
    assert missing_input(["--root-dir", there, "gone"]) == ""
