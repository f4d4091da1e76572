"""Modules of the page that need no browser: Node.js runs their tests, which are beside this file; hints of the page."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

import pyros1

ROOM = Path(pyros1.__file__).parent
TESTS = sorted(Path(__file__).with_name("page").glob("*.test.mjs"))


@pytest.mark.once
@pytest.mark.skipif(shutil.which("node") is None, reason="needs Node.js")
@pytest.mark.parametrize("file", TESTS, ids=lambda file: file.name.partition(".")[0])
def test_modules_of_the_page(file: Path) -> None:
    done = subprocess.run(["node", "--test", str(file)], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_programs_and_launch_files_of_hints_are_there() -> None:
    texts = [file.read_text(encoding="utf-8") for file in (ROOM / "web" / "page").rglob("*.js")]
    hints = {hint for text in texts for hint in re.findall(r"pyros1 (run|launch) (\w+) ([\w.]+)", text)}
    assert len(hints) > 5
    for verb, package, name in hints:
        assert (ROOM / "packages" / package / {"run": "scripts", "launch": "launch"}[verb] / name).is_file()
