"""Which Python runs a script, by its first line and place."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from pyros1.finding import python_modules
from pyros1.finding.python_modules import system_python


@pytest.fixture
def system(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder that counts as one of the system's packages; their Python is this one."""
    folder = tmp_path / "lib"
    folder.mkdir()
    monkeypatch.setattr(python_modules, "SYSTEM_FOLDERS", (f"{folder.resolve()}/",))
    monkeypatch.setattr(python_modules, "SYSTEM_PYTHON", sys.executable)
    return folder


@pytest.mark.parametrize("line", ["#!/usr/bin/env python3", "#!/usr/bin/env python", "#! /usr/bin/env python3"])
def test_scripts_of_the_system_run_in_its_python(system: Path, tmp_path: Path, line: str) -> None:
    script = system / "node"
    script.write_text(f"{line}\nimport node\n")
    assert system_python(script, {}) == sys.executable
    link = tmp_path / "link"
    link.symlink_to(script)
    assert system_python(link, {}) == sys.executable
    assert system_python(script, {"PYROS1_ROSPY": "pyros1"}) == ""
    (tmp_path / "mine").write_text(script.read_text())
    assert system_python(tmp_path / "mine", {}) == ""


@pytest.mark.parametrize("line", ["#!/usr/bin/python3", "#!/bin/sh", "\x7fELF", "#!/usr/bin/env python3.11", ""])
def test_other_programs_of_the_system_are_started_as_they_are(system: Path, line: str) -> None:
    (system / "node").write_text(f"{line}\n")
    assert system_python(system / "node", {}) == ""


def test_without_that_python_or_the_file(system: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert system_python(system / "absent", {}) == ""
    (system / "node").write_text("#!/usr/bin/env python3\n")
    monkeypatch.setattr(python_modules, "SYSTEM_PYTHON", str(system / "absent"))
    assert system_python(system / "node", {}) == ""
