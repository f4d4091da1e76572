"""Finds files in packages, for the verbs that correspond to rosbash's roscd, rosls, rosed, roscat, roscp (L184)."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence

from pyros1.cli.failures import did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import leave_unparsed
from pyros1.cli.records import Argument, Option, Verb
from pyros1.finding.crawl import all_packages
from pyros1.finding.packages import files_below
from pyros1.ground.errors import Error

_MAX_CHOICES = 100


class FilesError(Error):
    """Ends the command with an error message."""


def make_files_verb(
    name: str,
    tool: str,
    action: Callable[[list[str]], int],
    *parts: Option | Argument,
    about: str,
    examples: Sequence[tuple[str, str]],
) -> Verb:
    """Return the `Verb` for a command of rosbash.

    Args:
        name: the name of the verb.
        tool: the name of the command in rosbash, which is printed before errors.
        action: takes the arguments after the verb, runs the verb, and returns the exit code.
        parts: options and arguments.
        about: a one-line description.
        examples: the examples, see `Verb`.
    """

    def run(invocation: Invocation, options: None, args: list[str]) -> int:
        args = invocation.argv[1:]
        program = os.path.basename(sys.argv[0]) if sys.argv else ""
        as_stock = invocation.as_stock or program == tool
        if args in (["-h"], ["--help"]) and not as_stock and name != "cd":  # `roscd` changes to what cd prints
            from pyros1.cli.help import Parser  # noqa: PLC0415 - only needed for help

            print(Parser(verb, invocation).format_help(), end="")
            return 0
        try:
            return action(args)
        except (FilesError, OSError) as error:
            print(f"{tool}: {error}", file=sys.stderr)
            return 1

    verb = Verb(name, about, *parts, stock=tool, examples=examples, parse=leave_unparsed, run=run)
    return verb


def special_folders() -> dict[str, str]:
    """Return the special folders by name: ``log``, ``test_results``, and those in ROS_LOCATIONS."""
    home = os.environ.get("ROS_HOME") or os.path.expanduser("~/.ros")
    folders = {
        "log": os.environ.get("ROS_LOG_DIR") or os.path.join(home, "log"),
        "test_results": os.environ.get("ROS_TEST_RESULTS_DIR") or os.path.join(home, "test_results"),
    }
    for part in os.environ.get("ROS_LOCATIONS", "").split(":"):
        name, equals, path = part.partition("=")
        if equals and name:
            folders[name] = os.path.expanduser(path)
    return folders


def resolve_folder(location: str) -> str:
    """Return the path of ``package``, ``package/folder``, ``log`` or another special folder.

    Raises:
        FilesError: the package is unknown.
    """
    name, _, relative_path = location.partition("/")
    path = special_folders().get(name)
    if path is None:
        folders_by_package = {entry.name: entry.folder for entry in reversed(all_packages(os.environ))}
        path = folders_by_package.get(name)
        if path is None:
            raise FilesError(
                f"No such package/stack '{name}'{did_you_mean(name, {*folders_by_package, *special_folders()})}"
            )
    return os.path.normpath(os.path.join(path, relative_path))


def workspace_folder() -> str:
    """Return the folder of the workspace, to which ``roscd`` changes without arguments.

    Raises:
        FilesError: no workspace is known.
    """
    prefixes = os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)
    workspaces = [prefix for prefix in prefixes if prefix and os.path.isfile(os.path.join(prefix, ".catkin"))]
    folder = os.environ.get("ROS_WORKSPACE") or next(iter(workspaces), None)
    if folder is None:
        raise FilesError(
            "no workspace found: set ROS_WORKSPACE, source the setup.bash of a workspace (which sets "
            "CMAKE_PREFIX_PATH), or name a package"
        )
    return folder


def find_file(args: list[str], usage: str) -> str:
    """Return the path of the file given by the arguments ``PACKAGE FILE``. If several files match, ask the user.

    Raises:
        FilesError: arguments are missing, no file matches, or the user selected none.
    """
    if len(args) < 2:
        raise FilesError(f"usage: {usage}")
    folder, name = resolve_folder(args[0]), args[1]
    direct_path = os.path.join(folder, name)
    if os.path.dirname(name):
        paths = [direct_path] if os.path.isfile(direct_path) else []
    else:
        paths = [os.path.join(base, name) for base, files in files_below(folder) if name in files]
    if not paths:
        all_names = {file for _, files in files_below(folder) for file in files}
        raise FilesError(f"no file {name} in {folder}{did_you_mean(name, all_names)}")
    return paths[0] if len(paths) == 1 else _choose_path(paths)


def _choose_path(paths: list[str]) -> str:
    if not sys.stdin.isatty():
        return paths[0]
    print("You have chosen a non-unique filename, please pick one of the following:", file=sys.stderr)
    for number, path in enumerate(paths[:_MAX_CHOICES], 1):
        print(f"{number}) {path}", file=sys.stderr)
    print("#? ", end="", file=sys.stderr, flush=True)
    answer = sys.stdin.readline().strip()
    if not (answer.isdigit() and 0 < int(answer) <= len(paths)):
        raise FilesError("no file was selected")
    return paths[int(answer) - 1]
