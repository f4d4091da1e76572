"""``pyros1 guide``."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import pytest

from pyros1.cli.dispatch import usage
from pyros1.cli.running import run_command
from pyros1.guide import checks
from pyros1.guide.documents import pages, steps


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The reader's folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_list_and_each_step(capsys: Any) -> None:
    assert run_command("guide", []) == 0
    listed = capsys.readouterr().out
    for step in steps():
        assert f"{step.number:3}. {step.title}\n" in listed
        assert run_command("guide", [str(step.number)]) == 0
        shown = capsys.readouterr().out
        assert shown.startswith(f"{step.number}. {step.title}\n\n")
        assert "```" not in shown and "\n#" not in shown
        assert "\nExercise\n" in shown
        assert (f"pyros1 guide -w {step.number} writes" in shown) == bool(step.files)
        for command in (line for line in step.text.splitlines() if line.startswith("$ ")):
            assert f"    {command}\n" in shown


def test_it_leads_the_list_of_commands() -> None:
    assert re.findall(r"^  (\w\S*) ", usage(), re.M)[0] == "guide"


def test_the_pages(capsys: Any) -> None:
    assert run_command("guide", ["howto"]) == 0
    listed = capsys.readouterr().out
    for page in pages().values():
        assert re.search(rf"^  {page.name} +{re.escape(page.heading)}$", listed, re.M)
        assert run_command("guide", ["howto", page.name]) == 0
        assert capsys.readouterr().out.startswith(f"{page.heading}\n\n")


@pytest.mark.parametrize(("words", "hint"), [(["action"], " (did you mean 'actions'?)"), (["bags", "tests"], "")])
def test_a_page_that_there_is_not(words: list[str], hint: str, capsys: Any) -> None:
    with pytest.raises(SystemExit, match="2"):
        run_command("guide", ["howto", *words])
    assert f"there is no page {' '.join(words)}{hint}; the pages are access, actions," in capsys.readouterr().err


def test_files_are_written_and_never_over_others(folder: Path, capsys: Any) -> None:
    assert run_command("guide", ["-w", "2"]) == 0
    script = folder / "my_robot" / "scripts" / "counter"
    assert "wrote my_robot/scripts/counter" in capsys.readouterr().out
    assert os.access(script, os.X_OK)
    assert 'pyros1.Node("counter")' in script.read_text()
    assert run_command("guide", ["-w", "2"]) == 0
    script.write_text("mine")
    assert run_command("guide", ["--write", "2"]) == 1
    assert "already exists with different contents" in capsys.readouterr().err
    assert script.read_text() == "mine"
    assert run_command("guide", ["-w", "3"]) == 0


def test_an_exercise_is_checked(monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    said = iter(["no node publishes /topic2", "", ""])
    monkeypatch.setattr(checks, "check", lambda number: next(said))
    assert run_command("guide", ["check", "2"]) == 1
    assert capsys.readouterr().out == "2. A publisher and a subscriber is not done yet: no node publishes /topic2\n"
    assert run_command("guide", ["check", "2"]) == 0
    assert capsys.readouterr().out == "2. A publisher and a subscriber: done. Next: pyros1 guide 3\n"
    last = str(len(steps()))
    assert run_command("guide", ["check", last]) == 0
    assert capsys.readouterr().out.endswith("done. That was the last step.\n")


@pytest.mark.parametrize("words", [["0"], ["99"], ["x"], ["check"], ["check", "x"], ["1", "2"], ["-w"], ["-w", "99"]])
def test_a_step_that_there_is_not(words: list[str], capsys: Any) -> None:
    with pytest.raises(SystemExit, match="2"):
        run_command("guide", words)
    assert f"1 ... {len(steps())}" in capsys.readouterr().err
