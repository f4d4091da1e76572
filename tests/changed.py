"""Which tests a change is likely to break: prints paths for pytest, one per line.

::

    python tests/changed.py [COMMIT]    # of what differs from COMMIT [HEAD], new files included

A module's tests are in the folder below `tests` that mirrors its own. The rules of the house always count.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).resolve().parents[1]
RULES = "tests/test_project.py"
# The page's modules are tested by Node.js, for all of them.
PAGE = {"tests/web/test_page_modules.py", "tests/javascript", "tests/test_security.py"}
PUBLIC = {"tests/test_public_names.py", "tests/test_reference.py"}
# What all tests depend on.
COMMON = {
    "pyproject.toml",
    "src/pyros1/__init__.py",
    "src/pyros1_pytest.py",
    "tests/bodies.py",
    "tests/conftest.py",
    "tests/free_ports.py",
    "tests/parts.py",
}


def select(changed: Iterable[str], root: Path = ROOT) -> list[str]:
    """Return the files and folders of unit tests to run.

    Args:
        changed: paths relative to the root; files that no longer exist count, too.
        root: the checkout.
    """
    found = {RULES}
    for name in changed:
        path = PurePosixPath(name)
        if name in COMMON:
            return ["tests"]
        if path.is_relative_to("src/pyros1") and path.suffix == ".py":
            found |= {each for each in PUBLIC if (root / each).exists()}
        if path.is_relative_to("tests") and path.match("test_*.py"):
            if (root / path).exists():
                found.add(name)
        elif path.is_relative_to("tests/web/page"):
            found |= PAGE
        elif str(path.parent) in ("tests", "src/pyros1"):
            found |= {f"tests/test_{path.stem}.py"} if (root / f"tests/test_{path.stem}.py").exists() else set()
        elif path.is_relative_to("tests"):
            found.add(_nearest(path.parent, root))
        elif path.is_relative_to(".github/workflows"):
            found.add("tests/javascript")  # the same tools check them
        elif path.is_relative_to("src/pyros1/web/page"):
            found |= PAGE
        elif path.is_relative_to("src/pyros1"):
            found.add(_nearest("tests" / path.parent.relative_to("src/pyros1"), root))
        elif path.suffix == ".md":
            found.add("tests/guide")
    folders = {each for each in found if not each.endswith(".py")}
    return sorted(each for each in found if not any(each.startswith(f"{folder}/") for folder in folders))


def _nearest(folder: PurePosixPath, root: Path) -> str:
    """Return a folder, or the nearest one above it that exists; `RULES` if that is the top one."""
    while not (root / folder).is_dir():
        folder = folder.parent
    return RULES if folder == PurePosixPath("tests") else str(folder)


def changed_files(commit: str, root: Path = ROOT) -> list[str]:
    """Return what differs from a commit in the working tree, new files included.

    A file that was moved counts with both names.

    Raises:
        OSError: git is not installed.
        ValueError: there is no such commit, or no repository; the message is git's.
    """
    commands = (
        ["ls-files", "-zo", "--exclude-standard"],
        ["diff", "--name-only", "--no-renames", "--relative", "-z", "--end-of-options", commit, "--"],
    )
    names = []
    for words in commands:
        done = subprocess.run(["git", *words], cwd=root, capture_output=True, encoding="utf-8", check=False)
        if done.returncode:
            raise ValueError(done.stderr.strip())
        names += done.stdout.split("\0")
    return [name for name in names if name]


if __name__ == "__main__":
    try:
        print(*select(changed_files((sys.argv[1:] or ["HEAD"])[0])), sep="\n")
    except (OSError, ValueError) as error:
        sys.exit(f"tests/changed.py: {error}")
