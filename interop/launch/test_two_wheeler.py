"""The example of a robot: what is shipped is what xacro, from the registry, makes of its source."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from harness import SOURCE

ROBOT = SOURCE / "pyros1" / "packages" / "two_wheeler" / "urdf" / "two_wheeler.urdf"


def test_the_description_is_made_from_xacro(tmp_path: Path) -> None:
    words = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--target", str(tmp_path), "xacro>=2.0"]
    done = subprocess.run([sys.executable, *words], capture_output=True, text=True, timeout=110, check=False)
    assert done.returncode == 0, done.stderr
    made = subprocess.run(
        [sys.executable, "-m", "pyros1.launch.reading.xacro_tool", f"{ROBOT}.xacro"],
        env={"PYTHONPATH": f"{tmp_path}:{SOURCE}"},
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    written = ROBOT.read_text("utf-8")
    assert made.stdout.split("<robot", 1)[1].split() == written.split("<robot", 1)[1].split()
