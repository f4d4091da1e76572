"""``pkg edit`` and ``pkg cat``: rosed and roscat (L184)."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys

from pyros1.cli.commands.pkg._files import FilesError, file_of, files_verb
from pyros1.cli.records import Argument


def _edit(words: list[str]) -> int:
    editor = os.environ.get("EDITOR") or next((name for name in ("vim", "nano", "vi") if shutil.which(name)), "vi")
    return _run_on(editor, file_of(words, "rosed package file"))


def _cat(words: list[str]) -> int:
    return _run_on(os.environ.get("CATTER") or "cat", file_of(words, "roscat package file"))


def _run_on(program: str, path: str) -> int:
    sys.stdout.flush()
    words = shlex.split(program)
    try:
        return subprocess.run([*words, path], check=False).returncode
    except FileNotFoundError:
        raise FilesError(f"program {words[0]} not found: set EDITOR to an installed editor") from None


_FILE = (Argument("package", "package"), Argument("file", "package_file"))
VERBS = [
    files_verb(
        "edit",
        "rosed",
        _edit,
        *_FILE,
        about="edit a file of a package",
        examples=[("my_robot robot.launch", "a file anywhere in the package")],
    ),
    files_verb(
        "cat",
        "roscat",
        _cat,
        *_FILE,
        about="print a file of a package",
        examples=[("roscpp package.xml", "a file anywhere in the package")],
    ),
]
