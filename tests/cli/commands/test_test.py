"""``pyros1 test``: where results go, and whose master is used (L186)."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from pyros1.ground.errors import ParameterNotSetError
from pyros1.net.master_client import MasterClient

SOURCES = Path(__file__).resolve().parents[3] / "src"
PACKAGE = "<package format='2'><name>tested</name></package>"
# A test that succeeds, and tells which master it was given.
CHECK = """#!/bin/sh
for word; do case $word in --gtest_output=xml:*) file=${word#--gtest_output=xml:};; esac; done
echo "$ROS_MASTER_URI" > "$ROS_HOME/uri"
echo "seen on the screen"
[ -n "$file" ] && echo '<testsuite><testcase name="a" classname="c" time="0.5"/></testsuite>' > "$file"
"""
FILE = '<launch><param name="own" value="1"/><test pkg="tested" type="check" test-name="it"/></launch>'


class Answer(NamedTuple):
    """What the command said."""

    code: int
    out: str
    err: str


Ask = Callable[..., Answer]


@pytest.fixture
def ask(tmp_path: Path, environ: dict[str, str]) -> Ask:
    package = tmp_path / "tested"
    (package / "test").mkdir(parents=True)
    (package / "package.xml").write_text(PACKAGE)
    (package / "check").write_text(CHECK)
    (package / "check").chmod(0o755)
    (package / "test" / "all.test").write_text(FILE)
    home = tmp_path / "home"
    home.mkdir()
    env = {**os.environ, **environ, "PYTHONPATH": str(SOURCES), "ROS_PACKAGE_PATH": str(package), "ROS_HOME": str(home)}
    env.pop("ROS_TEST_RESULTS_DIR", None)

    def ask(*words: str) -> Answer:
        command = [sys.executable, "-m", "pyros1", "test", *words]
        done = subprocess.run(command, cwd=tmp_path, env=env, capture_output=True, text=True, timeout=60, check=False)
        return Answer(done.returncode, done.stdout, done.stderr)

    return ask


@pytest.fixture
def client(environ: dict[str, str]) -> Iterator[MasterClient]:
    """Speaks to the master that runs."""
    client = MasterClient("/test", environ["ROS_MASTER_URI"])
    yield client
    client.close()


def results(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*.xml"))


@pytest.mark.slow
def test_each_test_has_a_master_of_its_own(ask: Ask, tmp_path: Path, environ: dict[str, str]) -> None:
    assert ask("tested", "all.test").code == 0
    assert (tmp_path / "home" / "uri").read_text().strip() != environ["ROS_MASTER_URI"]
    found = results(tmp_path / "home" / "test_results")
    assert found == ["tested/rostest-test_all.xml", "tested/rosunit-it.xml"]


@pytest.mark.parametrize("flag", ["-r", "--reuse-master"])
def test_the_master_that_runs_can_be_used(ask: Ask, tmp_path: Path, client: MasterClient, flag: str) -> None:
    client.set_param("/before", 1)
    assert ask(flag, "tested", "all.test").code == 0
    assert (tmp_path / "home" / "uri").read_text().strip() == client.uri
    assert (client.get_param("/before"), client.get_param("/own")) == (1, 1)


@pytest.mark.slow
@pytest.mark.parametrize("flag", ["-c", "--clear"])
def test_its_parameters_can_be_deleted_first(ask: Ask, client: MasterClient, flag: str) -> None:
    client.set_param("/before", 1)
    client.set_param("/run_id", "kept")
    assert ask("-r", flag, "tested", "all.test").code == 0
    assert (client.get_param("/own"), client.get_param("/run_id")) == (1, "kept")
    with pytest.raises(ParameterNotSetError):
        client.get_param("/before")
    client.set_param("/before", 1)
    code, _, err = ask(flag, "tested", "all.test")
    assert code == 1 and "--clear option is only valid with --reuse-master" in err
    assert client.get_param("/before") == 1


@pytest.mark.slow
def test_results_go_where_they_are_wanted(ask: Ask, tmp_path: Path) -> None:
    place = tmp_path / "elsewhere"
    words = ["--results-base-dir", str(place), "--results-filename", "name.xml", "--package", "other"]
    assert ask(*words, "tested", "all.test").code == 0
    assert results(place) == ["other/rostest-name.xml", "other/rosunit-it.xml"]
    assert not (tmp_path / "home" / "test_results").exists()
    assert ask("--results-base-dir", str(place), "--pkgdir", str(tmp_path), "tested", "all.test").code == 0
    assert "tested/rostest-tested_test_all.xml" in results(place)


@pytest.mark.slow
@pytest.mark.parametrize("flag", ["-t", "--text"])
def test_text_instead_of_results(ask: Ask, tmp_path: Path, flag: str) -> None:
    code, out, _ = ask(flag, "tested", "all.test")
    assert code == 0 and "seen on the screen" in out
    assert "WARNING: overall test result is not accurate when --text is enabled" in out
    assert not any("rostest-" in name for name in results(tmp_path / "home"))


@pytest.mark.slow
def test_wrong_words(ask: Ask, tmp_path: Path) -> None:
    assert ask().code == 2
    code, _, err = ask("none.test")
    assert code == 2 and "test file is invalid. Generated failure case result file in" in err
    assert len(results(tmp_path / "home")) == 1
    assert ask("tested", "none.test").code == 1
