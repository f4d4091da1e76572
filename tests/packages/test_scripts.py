"""The scripts of the packages that come along: one text, and a table of what each runs."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import pyros1
from pyros1.cli import registry
from pyros1.cli.package_scripts import SCRIPTS
from pyros1.finding.packages import PackageIndex
from pyros1.test_nodes.program import NODES

pytestmark = pytest.mark.once

PACKAGES = Path(pyros1.__file__).parent / "packages"
FILES = {
    path
    for path in PACKAGES.rglob("*")
    if path.is_file() and os.access(path, os.X_OK) and "minimal_nodes" not in path.parts
}


def test_the_table_and_the_files_are_the_same() -> None:
    listed = {(package, name) for package, names in SCRIPTS.items() for name in names}
    assert {(path.relative_to(PACKAGES).parts[0], path.name) for path in FILES} == listed
    assert len(FILES) == len(listed)
    assert {*SCRIPTS["rostest"], "analyzer_loader"} == {*NODES}


def test_all_files_are_one_text() -> None:
    assert len({path.read_bytes() for path in FILES}) == 1


@pytest.mark.parametrize("package", SCRIPTS)
def test_each_is_found_and_is_a_command(package: str) -> None:
    index = PackageIndex({}, installs=[])
    for name, script in SCRIPTS[package].items():
        assert index.find_executable(package, name), name
        if isinstance(script, str):
            command, *words = script.split()
            verbs = registry.verbs(command)
            assert registry.command_name(command) == command
            assert not words or words[0] in verbs or not verbs, f"{package}/{name}"


def test_a_link_under_another_name_will_do(tmp_path: Path) -> None:
    (tmp_path / "forward").symlink_to(PACKAGES / "topic_tools" / "scripts" / "relay")
    env = {**os.environ, "PYTHONPATH": str(PACKAGES.parents[1])}
    done = subprocess.run(
        [sys.executable, tmp_path / "forward", "-h"], env=env, capture_output=True, text=True, timeout=60, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "relay IN_TOPIC" in done.stdout


@pytest.mark.slow
@pytest.mark.parametrize(
    "script",
    sorted(
        path
        for path in FILES
        if callable(SCRIPTS[path.relative_to(PACKAGES).parts[0]][path.name]) and path.name != "xacro"
    ),
    ids=lambda path: path.name,
)
def test_a_wrong_address_of_the_master_is_one_line(script: Path) -> None:
    env = {**os.environ, "PYTHONPATH": str(PACKAGES.parents[1]), "ROS_MASTER_URI": "foo"}
    words = [sys.executable, script, "raw", "in:=a", "compressed", "out:=b"]
    done = subprocess.run(words, env=env, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode not in (0, -6) and "Traceback" not in done.stderr, done.stderr
