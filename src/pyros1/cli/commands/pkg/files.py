"""``pkg cd``, ``ls``, ``cp``, ``mv``, ``edit`` and ``cat``: work with files in packages, like rosbash (L184)."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys

from pyros1.cli.commands.pkg._files import FilesError, find_file, make_files_verb, resolve_folder, workspace_folder
from pyros1.cli.records import Argument, Flag


def _cd(args: list[str]) -> int:
    if len(args) > 1 or args in (["-h"], ["--help"]):
        raise FilesError("usage: roscd [package[/folder]]")
    path = resolve_folder(args[0]) if args and args[0] else workspace_folder()
    if not os.path.isdir(path):
        raise FilesError(f"{path} is not a folder")
    print(path)
    return 0


def _ls(args: list[str]) -> int:
    options = [arg for arg in args if arg.startswith("-")]
    locations = [arg for arg in args if not arg.startswith("-")]
    paths = [resolve_folder(location) for location in locations] or [workspace_folder()]
    sys.stdout.flush()
    return subprocess.run(["ls", *options, *paths], check=False).returncode


def _cp(args: list[str]) -> int:
    return _copy_or_move("cp", args)


def _mv(args: list[str]) -> int:
    """Run ``mv [-d] PACKAGE FILE TARGET``. With ``-d``, the target is ``package/folder``."""
    if args[:1] == ["-d"]:
        args = [*args[1:-1], resolve_folder(args[-1])]
    return _copy_or_move("mv", args)


def _copy_or_move(program: str, args: list[str]) -> int:
    if len(args) != 3:
        raise FilesError(f"usage: ros{program} package file target")
    return subprocess.run([program, find_file(args, ""), args[2]], check=False).returncode


def _edit(args: list[str]) -> int:
    default = next((name for name in ("vim", "nano", "vi") if shutil.which(name)), "vi")
    return _run_with_file("EDITOR", default, find_file(args, "rosed package file"))


def _cat(args: list[str]) -> int:
    return _run_with_file("CATTER", "cat", find_file(args, "roscat package file"))


def _run_with_file(variable: str, default: str, path: str) -> int:
    """Run the program that an environment variable names, or the default program, with a file; return its exit code."""
    sys.stdout.flush()
    try:
        command = shlex.split(os.environ.get(variable, "")) or [default]
        return subprocess.run([*command, path], check=False).returncode
    except (OSError, ValueError) as error:  # ValueError: a quotation mark is missing
        reason = "not found" if isinstance(error, FileNotFoundError) else error
        name = os.environ.get(variable) or default
        raise FilesError(f"program {name}: {reason}; set {variable} to an installed program") from None


_LOCATION_ARGUMENT = Argument("package[/folder]", "package|package_folder", optional=True)
_FILE_ARGUMENTS = (Argument("package", "package"), Argument("file", "package_file"))
_TARGET_ARGUMENT = Argument("target", "file")
VERBS = [
    make_files_verb(
        "cd",
        "roscd",
        _cd,
        _LOCATION_ARGUMENT,
        about="print a package's folder",
        examples=[("roscpp", "print the folder that `roscd roscpp` changes to")],
    ),
    make_files_verb(
        "ls",
        "rosls",
        _ls,
        _LOCATION_ARGUMENT,
        about="list a package's folder",
        examples=[
            ("roscpp", "list a package's folder"),
            ("-l roscpp/srv", "list a subfolder, with an option of ls"),
        ],
    ),
    make_files_verb(
        "cp",
        "roscp",
        _cp,
        *_FILE_ARGUMENTS,
        _TARGET_ARGUMENT,
        about="copy a file from a package",
        examples=[("my_robot robot.launch .", "copy a file to this folder")],
    ),
    make_files_verb(
        "mv",
        "rosmv",
        _mv,
        Flag("-d", help="the target is package/folder"),
        *_FILE_ARGUMENTS,
        _TARGET_ARGUMENT,
        about="move a file from a package",
        examples=[
            ("my_robot robot.launch .", "move a file to this folder"),
            ("-d my_robot robot.launch my_robot/old", "move a file to a folder of a package"),
        ],
    ),
    make_files_verb(
        "edit",
        "rosed",
        _edit,
        *_FILE_ARGUMENTS,
        about="edit a file from a package",
        examples=[("my_robot robot.launch", "edit a file anywhere in the package")],
    ),
    make_files_verb(
        "cat",
        "roscat",
        _cat,
        *_FILE_ARGUMENTS,
        about="print a file from a package",
        examples=[("roscpp package.xml", "print a file anywhere in the package")],
    ),
]
