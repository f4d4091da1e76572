"""`tests/javascript/check` without npm; with npm, `tests/run` runs it."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

CHECK = Path(__file__).with_name("check")


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
def test_the_check_says_what_is_missing(tmp_path: Path) -> None:
    (tmp_path / "dirname").symlink_to(shutil.which("dirname") or "")
    bash = shutil.which("bash") or ""
    done = subprocess.run([bash, CHECK], env={"PATH": str(tmp_path)}, capture_output=True, text=True, check=False)
    assert (
        done.returncode == 1
        and done.stderr == "tests/javascript/check: npm is missing (Debian: apt-get install nodejs npm)\n"
    )
