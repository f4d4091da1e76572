"""Which tests `tests/run --changed` runs."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from tests.changed import COMMON, PAGE, PUBLIC, ROOT, RULES, changed_files, select


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    for folder in ("tests/node/publishing", "tests/guide", "tests/wire"):
        (tmp_path / folder).mkdir(parents=True)
    for file in (
        *PUBLIC,
        "tests/test_graph.py",
        "tests/test_turn.py",
        "tests/node/test_clock.py",
        "tests/node/publishing/test_tcp_link.py",
        "tests/wire/test_http.py",
    ):
        (tmp_path / file).touch()
    return tmp_path


@pytest.mark.parametrize(
    ("changed", "tests"),
    [
        ([], []),
        (["src/pyros1/node/publishing/tcp_link.py"], ["tests/node/publishing"]),
        (["src/pyros1/node/services/provider_connection.py"], ["tests/node"]),  # a folder without tests of its own
        (["src/pyros1/wire/http.py", "src/pyros1/node/clock.py"], ["tests/node", "tests/wire"]),
        (["src/pyros1/node/clock.py", "src/pyros1/node/publishing/tcp_link.py"], ["tests/node"]),
        (["tests/node/test_clock.py"], ["tests/node/test_clock.py"]),
        (["tests/node/publishing/test_tcp_link.py"], ["tests/node/publishing/test_tcp_link.py"]),
        (["tests/node/test_gone.py"], []),
        (["tests/node/test_clock.py", "tests/node/parts.py"], ["tests/node"]),
        (["src/pyros1/graph.py"], ["tests/test_graph.py"]),
        (["src/pyros1/__main__.py", "interop/topics/test_latch_rospy.py"], []),
        (["tests/turn.py"], ["tests/test_turn.py"]),
        (["tests/coverage_floor.py", "LICENSE"], []),
        (["README.md"], ["tests/guide"]),
        (["src/pyros1/web/page/lib/dom.js"], sorted(PAGE)),
        (["tests/web/page/robot.test.mjs"], sorted(PAGE)),
        ([".github/workflows/tests.yml"], ["tests/javascript"]),
    ],
)
def test_tests_of_the_rooms_of_a_change(checkout: Path, changed: list[str], tests: list[str]) -> None:
    public = PUBLIC if any(name.startswith("src/") and name.endswith(".py") for name in changed) else ()
    assert select(changed, checkout) == sorted([RULES, *public, *tests])


@pytest.mark.parametrize("changed", ["pyproject.toml", "tests/conftest.py", "src/pyros1/__init__.py"])
def test_what_all_tests_depend_on(checkout: Path, changed: str) -> None:
    assert select(["src/pyros1/node/clock.py", changed], checkout) == ["tests"]


def test_files_that_count_for_all_tests_exist() -> None:
    assert all((ROOT / name).exists() for name in (*COMMON, *PUBLIC, *PAGE))


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "a.py").write_text("".join(f"line {number}\n" for number in range(20)))
    git(tmp_path, "init", "--quiet")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "--quiet", "-m", "first")
    return tmp_path


def git(folder: Path, *words: str) -> None:
    author = ("-c", "user.name=a", "-c", "user.email=a@example.org")
    subprocess.run(["git", *author, *words], cwd=folder, check=True)


def test_a_moved_file_counts_with_both_names(repository: Path) -> None:
    """Otherwise the tests of the room that it left would not run."""
    (repository / "new").mkdir()
    git(repository, "mv", "old/a.py", "new/a.py")
    assert sorted(changed_files("HEAD", repository)) == ["new/a.py", "old/a.py"]


def test_names_are_those_of_the_files(repository: Path) -> None:
    for name in ("tracked ü.py", "new ü.py"):
        (repository / name).touch()
    git(repository, "add", "tracked ü.py")
    assert sorted(changed_files("HEAD", repository)) == ["new ü.py", "tracked ü.py"]


def test_a_branch_may_have_the_name_of_a_folder(repository: Path) -> None:
    git(repository, "branch", "old")
    (repository / "old" / "a.py").write_text("")
    assert changed_files("old", repository) == ["old/a.py"]


def test_git_says_what_is_wrong(repository: Path) -> None:
    with pytest.raises(ValueError, match="nope"):
        changed_files("nope", repository)
