"""Files of packages: ``pyros1 pkg cd|ls|edit|cat|cp|mv``, as rosbash's roscd, rosls, rosed, roscat, roscp (L184)."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable

from pyros1.cli.common import did_you_mean
from pyros1.errors import Error
from pyros1.finding.crawl import all_packages
from pyros1.finding.packages import files_below

NAMES = {"cd": "roscd", "ls": "rosls", "edit": "rosed", "cat": "roscat", "cp": "roscp", "mv": "rosmv"}
"""Verb -> the stock tools' name."""
_MOST_CHOICES = 100


class _FilesError(Error):
    """Ends the command with this text."""


def main(argv: list[str]) -> int:
    """Run a verb.

    Args:
        argv: the verb and its words.

    Returns:
        The exit code: 1 after an error, 64 after the usage text.
    """
    verb, *words = argv
    try:
        return _VERBS[verb](words)
    except (_FilesError, OSError) as error:
        print(f"{NAMES[verb]}: {error}", file=sys.stderr)
        return 1


def special_places() -> dict[str, str]:
    """The places that have a name without being packages: ``log``, ``test_results`` and those of ROS_LOCATIONS."""
    home = os.environ.get("ROS_HOME") or os.path.expanduser("~/.ros")
    places = {
        "log": os.environ.get("ROS_LOG_DIR") or os.path.join(home, "log"),
        "test_results": os.environ.get("ROS_TEST_RESULTS_DIR") or os.path.join(home, "test_results"),
    }
    for part in os.environ.get("ROS_LOCATIONS", "").split(":"):
        name, equals, path = part.partition("=")
        if equals and name:
            places[name] = os.path.expanduser(path)
    return places


def folder_of(place: str) -> str:
    """Return the folder that ``package``, ``package/folder``, ``log`` or another name of a place means.

    Raises:
        Error: there is no such package.
    """
    name, _, inside = place.partition("/")
    path = special_places().get(name)
    if path is None:
        known = {found.name: found.folder for found in reversed(all_packages(os.environ))}
        path = known.get(name)
        if path is None:
            raise _FilesError(f"No such package/stack '{name}'{did_you_mean(name, {*known, *special_places()})}")
    return os.path.normpath(os.path.join(path, inside))


def _home_of_packages() -> str:
    """Where ``roscd`` alone goes: the workspace."""
    prefixes = os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)
    spaces = [prefix for prefix in prefixes if prefix and os.path.isfile(os.path.join(prefix, ".catkin"))]
    place = os.environ.get("ROS_WORKSPACE") or next(iter(spaces), None)
    if place is None:
        raise _FilesError(
            "neither ROS_WORKSPACE nor, with a workspace in it, CMAKE_PREFIX_PATH is set: "
            "source the setup.bash of a workspace, or name a package"
        )
    return place


def _cd(words: list[str]) -> int:
    if len(words) > 1 or words in (["-h"], ["--help"]):
        raise _FilesError("usage: roscd [package[/folder]]")
    path = folder_of(words[0]) if words and words[0] else _home_of_packages()
    if not os.path.isdir(path):
        raise _FilesError(f"{path} is no folder")
    print(path)
    return 0


def _ls(words: list[str]) -> int:
    options = [word for word in words if word.startswith("-")]
    places = [word for word in words if not word.startswith("-")]
    paths = [folder_of(place) for place in places] or [_home_of_packages()]
    sys.stdout.flush()
    return subprocess.run(["ls", *options, *paths], check=False).returncode


def _file(words: list[str], usage: str) -> str:
    """The file that ``PACKAGE FILE`` means, asked for if there are several of that name."""
    if len(words) < 2:
        raise _FilesError(f"usage: {usage}")
    folder, name = folder_of(words[0]), words[1]
    direct = os.path.join(folder, name)
    if os.path.dirname(name):
        found = [direct] if os.path.isfile(direct) else []
    else:
        found = [os.path.join(base, name) for base, files in files_below(folder) if name in files]
    if not found:
        everything = {file for _, files in files_below(folder) for file in files}
        raise _FilesError(f"there is no file {name} in {folder}{did_you_mean(name, everything)}")
    return found[0] if len(found) == 1 else _choose(found)


def _choose(found: list[str]) -> str:
    if not sys.stdin.isatty():
        return found[0]
    print("You have chosen a non-unique filename, please pick one of the following:", file=sys.stderr)
    for number, path in enumerate(found[:_MOST_CHOICES], 1):
        print(f"{number}) {path}", file=sys.stderr)
    print("#? ", end="", file=sys.stderr, flush=True)
    answer = sys.stdin.readline().strip()
    if not (answer.isdigit() and 0 < int(answer) <= len(found)):
        raise _FilesError("nothing was chosen")
    return found[int(answer) - 1]


def _run_on(program: str, path: str) -> int:
    sys.stdout.flush()
    words = shlex.split(program)
    try:
        return subprocess.run([*words, path], check=False).returncode
    except FileNotFoundError:
        raise _FilesError(f"there is no program {words[0]}") from None


def _edit(words: list[str]) -> int:
    editor = os.environ.get("EDITOR") or next((name for name in ("vim", "nano", "vi") if shutil.which(name)), "vi")
    return _run_on(editor, _file(words, "rosed package file"))


def _cat(words: list[str]) -> int:
    return _run_on(os.environ.get("CATTER") or "cat", _file(words, "roscat package file"))


def _cp(words: list[str]) -> int:
    return _carry("cp", words)


def _mv(words: list[str]) -> int:
    """``mv [-d] PACKAGE FILE TARGET``; with -d the target is ``package/folder``."""
    if words[:1] == ["-d"]:
        words = [*words[1:-1], folder_of(words[-1])]
    return _carry("mv", words)


def _carry(program: str, words: list[str]) -> int:
    if len(words) != 3:
        raise _FilesError(f"usage: ros{program} package file target")
    return subprocess.run([program, _file(words, ""), words[2]], check=False).returncode


_VERBS: dict[str, Callable[[list[str]], int]] = {
    "cd": _cd,
    "ls": _ls,
    "edit": _edit,
    "cat": _cat,
    "cp": _cp,
    "mv": _mv,
}
