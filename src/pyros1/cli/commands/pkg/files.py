"""``pkg cd``, ``ls``, ``cp``, ``mv``, ``edit`` and ``cat``: rosbash's commands for files of packages (L184)."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys

from pyros1.cli.commands.pkg._files import FilesError, file_of, files_verb, folder_of, home_of_packages
from pyros1.cli.records import Argument, Flag


def _cd(words: list[str]) -> int:
    if len(words) > 1 or words in (["-h"], ["--help"]):
        raise FilesError("usage: roscd [package[/folder]]")
    path = folder_of(words[0]) if words and words[0] else home_of_packages()
    if not os.path.isdir(path):
        raise FilesError(f"{path} is not a folder")
    print(path)
    return 0


def _ls(words: list[str]) -> int:
    options = [word for word in words if word.startswith("-")]
    places = [word for word in words if not word.startswith("-")]
    paths = [folder_of(place) for place in places] or [home_of_packages()]
    sys.stdout.flush()
    return subprocess.run(["ls", *options, *paths], check=False).returncode


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


_PLACE = Argument("package[/folder]", "package|place", optional=True)
_FILE = (Argument("package", "package"), Argument("file", "package_file"))
_TARGET = Argument("target", "file")
VERBS = [
    files_verb(
        "cd",
        "roscd",
        _cd,
        _PLACE,
        about="print a package's folder",
        examples=[("roscpp", "the folder that `roscd roscpp` changes to")],
    ),
    files_verb(
        "ls",
        "rosls",
        _ls,
        _PLACE,
        about="list a package's folder",
        examples=[
            ("roscpp", "the content of its folder"),
            ("-l roscpp/srv", "one of its subfolders, with options of ls"),
        ],
    ),
    files_verb(
        "cp",
        "roscp",
        _cp,
        *_FILE,
        _TARGET,
        about="copy a file of a package",
        examples=[("my_robot robot.launch .", "into this folder")],
    ),
    files_verb(
        "mv",
        "rosmv",
        _mv,
        Flag("-d", help="the target is package/folder"),
        *_FILE,
        _TARGET,
        about="move a file of a package",
        examples=[
            ("my_robot robot.launch .", "into this folder"),
            ("-d my_robot robot.launch my_robot/old", "into a folder of a package"),
        ],
    ),
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
