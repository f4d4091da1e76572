"""``pkg cp`` and ``pkg mv``: roscp and rosmv (L184)."""

from __future__ import annotations

import subprocess

from pyros1.cli.commands.pkg._files import FilesError, file_of, files_verb, folder_of
from pyros1.cli.records import Argument, Flag


def _cp(words: list[str]) -> int:
    return _carry("cp", words)


def _mv(words: list[str]) -> int:
    """Run ``mv [-d] PACKAGE FILE TARGET``. With -d the target is ``package/folder``."""
    if words[:1] == ["-d"]:
        words = [*words[1:-1], folder_of(words[-1])]
    return _carry("mv", words)


def _carry(program: str, words: list[str]) -> int:
    if len(words) != 3:
        raise FilesError(f"usage: ros{program} package file target")
    return subprocess.run([program, file_of(words, ""), words[2]], check=False).returncode


_WORDS = (Argument("package", "package"), Argument("file", "package_file"), Argument("target", "file"))
VERBS = [
    files_verb(
        "cp",
        "roscp",
        _cp,
        *_WORDS,
        about="copy a file of a package",
        examples=[("my_robot robot.launch .", "into this folder")],
    ),
    files_verb(
        "mv",
        "rosmv",
        _mv,
        Flag("-d", help="the target is package/folder"),
        *_WORDS,
        about="move a file of a package",
        examples=[
            ("my_robot robot.launch .", "into this folder"),
            ("-d my_robot robot.launch my_robot/old", "into a folder of a package"),
        ],
    ),
]
