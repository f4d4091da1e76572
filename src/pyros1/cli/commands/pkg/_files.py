"""Files of packages, as rosbash's roscd, rosls, rosed, roscat and roscp find them (L184)."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence

from pyros1.cli.failures import did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import leave_words
from pyros1.cli.records import Argument, Option, Verb
from pyros1.finding.crawl import all_packages
from pyros1.finding.packages import files_below
from pyros1.ground.errors import Error

_MAX_CHOICES = 100


class FilesError(Error):
    """Ends the command with an error text."""


def files_verb(
    name: str,
    tool: str,
    work: Callable[[list[str]], int],
    *parts: Option | Argument,
    about: str,
    examples: Sequence[tuple[str, str]],
) -> Verb:
    """Return the record of a verb that is a separate command in stock ROS.

    Args:
        name: name of the verb.
        tool: the stock command, which is printed before errors.
        work: runs the verb: takes the words after it, returns the exit code.
        parts: options and arguments.
        about: description in one line.
        examples: see `Verb`.
    """

    def run(invocation: Invocation, options: None, args: list[str]) -> int:
        words = invocation.argv[1:]
        called = os.path.basename(sys.argv[0]) if sys.argv else ""
        as_stock = invocation.as_stock or called == tool
        if words in (["-h"], ["--help"]) and not as_stock and name != "cd":  # the shell changes to what cd prints
            from pyros1.cli.help import Parser  # noqa: PLC0415 - only needed for help

            print(Parser(verb, invocation).format_help(), end="")
            return 0
        try:
            return work(words)
        except (FilesError, OSError) as error:
            print(f"{tool}: {error}", file=sys.stderr)
            return 1

    verb = Verb(name, about, *parts, stock=tool, examples=examples, parse=leave_words, run=run)
    return verb


def special_places() -> dict[str, str]:
    """Return named folders that are not packages: ``log``, ``test_results``, and those in ROS_LOCATIONS."""
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
    """Return the folder of ``package``, ``package/folder``, ``log`` or another special name.

    Raises:
        Error: the package is unknown.
    """
    name, _, inside = place.partition("/")
    path = special_places().get(name)
    if path is None:
        known = {found.name: found.folder for found in reversed(all_packages(os.environ))}
        path = known.get(name)
        if path is None:
            raise FilesError(f"No such package/stack '{name}'{did_you_mean(name, {*known, *special_places()})}")
    return os.path.normpath(os.path.join(path, inside))


def home_of_packages() -> str:
    """Return where ``roscd`` alone goes: the workspace."""
    prefixes = os.environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)
    spaces = [prefix for prefix in prefixes if prefix and os.path.isfile(os.path.join(prefix, ".catkin"))]
    place = os.environ.get("ROS_WORKSPACE") or next(iter(spaces), None)
    if place is None:
        raise FilesError(
            "no workspace found: set ROS_WORKSPACE, source the setup.bash of a workspace (which sets "
            "CMAKE_PREFIX_PATH), or name a package"
        )
    return place


def file_of(words: list[str], usage: str) -> str:
    """Return the file for ``PACKAGE FILE``. If several files have this name, ask the user."""
    if len(words) < 2:
        raise FilesError(f"usage: {usage}")
    folder, name = folder_of(words[0]), words[1]
    direct = os.path.join(folder, name)
    if os.path.dirname(name):
        found = [direct] if os.path.isfile(direct) else []
    else:
        found = [os.path.join(base, name) for base, files in files_below(folder) if name in files]
    if not found:
        everything = {file for _, files in files_below(folder) for file in files}
        raise FilesError(f"no file {name} in {folder}{did_you_mean(name, everything)}")
    return found[0] if len(found) == 1 else _choose(found)


def _choose(found: list[str]) -> str:
    if not sys.stdin.isatty():
        return found[0]
    print("You have chosen a non-unique filename, please pick one of the following:", file=sys.stderr)
    for number, path in enumerate(found[:_MAX_CHOICES], 1):
        print(f"{number}) {path}", file=sys.stderr)
    print("#? ", end="", file=sys.stderr, flush=True)
    answer = sys.stdin.readline().strip()
    if not (answer.isdigit() and 0 < int(answer) <= len(found)):
        raise FilesError("no file was selected")
    return found[int(answer) - 1]
