"""Which part of the long tests `.ci/run` runs for a commit: prints files for pytest, one per line.

::

    python tests/turn.py 2/3 interop/web tests/cli   # the third of the three parts: those numbered 2, 5, 8 ...
    python tests/turn.py "" interop/web              # all of them

Part K of N has every Nth file, so that N turns run all of them. A file that changed lately has no time to wait for its
turn: it is in every part.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Container
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LATELY = 10  # commits
BY_HAND = {"interop/ros2/test_rclpy.py", "interop/web/test_real_bags.py"}
"""Tests that need what is not everywhere; the conftest.py of their folders says what."""


def select(turn: str, paths: list[str], changed: Container[str] = (), root: Path = ROOT) -> list[str]:
    """Return the files of tests whose turn it is.

    Args:
        turn: ``K/N`` with 0 <= K < N, or empty for all.
        paths: files and folders of tests, relative to the root.
        changed: files that are in every part.
        root: the checkout.

    Raises:
        ValueError: if `turn` is anything else, or a path does not exist.
    """
    number, _, count = (turn or "0/1").partition("/")
    if not (number.isdecimal() and count.isdecimal() and int(number) < int(count)):
        raise ValueError(f"TURN is K/N, part K of N counted from 0, not {turn!r}")
    missing = [path for path in paths if not (root / path).exists()]
    if missing:
        raise ValueError(f"there is no {missing[0]}")
    files = sorted({str(file.relative_to(root)) for path in paths for file in _files(root / path)} - BY_HAND)
    return [file for index, file in enumerate(files) if index % int(count) == int(number) or file in changed]


def _files(path: Path) -> list[Path]:
    return [path] if path.is_file() else list(path.rglob("test_*.py"))


def changed_lately() -> set[str]:
    """Return the files that the last `LATELY` commits touched; none where there is no history."""
    command = ["git", "log", f"-{LATELY}", "--name-only", "--format="]
    try:
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    except FileNotFoundError:  # no git
        return set()
    return set(done.stdout.splitlines())


if __name__ == "__main__":
    try:
        print(*select("".join(sys.argv[1:2]), sys.argv[2:], changed_lately()), sep="\n")
    except ValueError as error:
        sys.exit(f"tests/turn.py: {error}")
