"""Which part of the long tests `.ci/run` runs for a commit."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.turn import changed_lately, select

FILES = ["interop/web/test_a.py", "interop/web/test_b.py", "interop/web/test_c.py", "tests/cli/topic/test_echo.py"]


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    for name in [*FILES, "interop/web/conftest.py"]:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    return tmp_path


@pytest.mark.parametrize("count", [1, 2, 3, 7])
def test_the_parts_together_have_each_file_once(checkout: Path, count: int) -> None:
    parts = [select(f"{number}/{count}", ["interop/web", "tests/cli"], root=checkout) for number in range(count)]
    assert sorted(file for part in parts for file in part) == FILES


def test_without_a_turn_all_files_run(checkout: Path) -> None:
    assert select("", ["tests", "interop/web/test_b.py"], root=checkout) == [FILES[1], FILES[3]]


def test_what_changed_lately_is_in_every_part(checkout: Path) -> None:
    assert select("0/3", ["interop"], {FILES[1], "README.md"}, root=checkout) == FILES[:2]


@pytest.mark.parametrize("turn", ["3/3", "-1/3", "1", "1/0", "a/b", "1/3/5"])
def test_what_is_no_turn_is_refused(checkout: Path, turn: str) -> None:
    with pytest.raises(ValueError, match="K/N"):
        select(turn, ["interop"], root=checkout)


def test_a_misspelt_path_is_an_error(checkout: Path) -> None:
    """Its tests would be left out, and nobody would notice."""
    with pytest.raises(ValueError, match="there is no interop/wbe"):
        select("", ["interop/web", "interop/wbe"], root=checkout)


def test_without_git_nothing_changed_lately(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert changed_lately() == set()
