"""``pyros1 run``: runs an executable from a package (https://wiki.ros.org/rosbash#rosrun)."""

from __future__ import annotations

import os
import shlex
import sys
from pathlib import Path
from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Command, Flag, Option, Verb
from pyros1.finding.packages import PackageIndex
from pyros1.ground.errors import PackageNotFoundError
from pyros1.ground.suggest import argument_hint, did_you_mean
from pyros1.launch.running.command_line import executable_words, is_own, program_environment
from pyros1.launch.running.shebang import script_problem

_OPTIONS_WITH_VALUE = ("-p", "--prefix")


class _Options:
    """The parsed command line.

    Attributes:
        prefix: the words of the command that runs the program, such as a debugger.
        debug: whether to print the executables that were found.
        unusable_option: an unknown option, or an option that lacks its value; empty if there is none.
        args: the package, the executable and its arguments.
        shows_usage: whether to print the usage, because an option is invalid or the executable is missing.
    """

    def __init__(self, argv: list[str]) -> None:
        args = list(argv)
        self.prefix: list[str] = []
        self.debug = False
        self.unusable_option = ""
        while args and args[0].startswith("-"):
            option = args.pop(0)
            if option in ("-d", "--debug"):
                self.debug = True
            elif option in _OPTIONS_WITH_VALUE and args:
                self.prefix = shlex.split(args.pop(0))
            elif option.startswith("--prefix="):
                self.prefix = shlex.split(option.partition("=")[2])
            else:
                self.unusable_option = option
        self.args = args
        self.shows_usage = bool(self.unusable_option) or len(args) < 2


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Replace this process with the program (L22-L24), or print usage or a package's executables.

    Returns:
        The exit code if nothing was run: 0 after usage or a list was printed, 1 for a name that ends with a slash, 2
        for an unknown package, 3 for an unknown executable.

    Raises:
        UsageError: an option is unknown or lacks its value. ``rosrun`` prints the usage and returns 0 instead.
    """
    if options.unusable_option not in ("", "-h", "--help") and not invocation.as_stock:
        if options.unusable_option in _OPTIONS_WITH_VALUE:
            raise UsageError(f"{options.unusable_option} needs a value")
        raise UsageError(f"no such option: {options.unusable_option}{_similar_option_hint(options.unusable_option)}")
    if options.shows_usage:
        has_only_package = len(args) == 1 and not options.unusable_option and not invocation.as_stock
        return _print_executables(args[0]) if has_only_package else _print_usage(invocation)
    package, executable_name, *arguments = args
    if executable_name.endswith("/"):
        print(f"[rosrun] Couldn't find executable named {executable_name}", file=sys.stderr)
        return 1
    package_index = PackageIndex(os.environ)
    try:
        executables = package_index.find_executable(package, executable_name)
    except PackageNotFoundError as error:
        _print_unknown_package(package_index, package)
        if options.debug:
            print(f"[rosrun] {error}", file=sys.stderr)
        return 2
    if options.debug:
        print(f"[rosrun] found: {', '.join(map(str, executables)) or 'nothing'}")
    if not executables:
        _print_missing_executable(package_index, package, executable_name, package_index.find(package))
        return 3
    executable = executables[0] if len(executables) == 1 else _select_executable(executables)
    if executable is None:
        return 0
    for argument in arguments:
        hint = argument_hint(argument)
        if hint:
            print(f"[rosrun] {hint}; the argument is passed to the program unchanged", file=sys.stderr)
    return _execute_command([*options.prefix, *executable_words(executable), *arguments], executable)


def _similar_option_hint(option_text: str) -> str:
    return did_you_mean(option_text.partition("=")[0], [name for option in _VERB.options for name in option.names])


def _execute_command(command: list[str], executable: Path) -> int:
    is_own_script = is_own(executable)
    environ = {**os.environ, **program_environment(executable, os.environ)}
    sys.stdout.flush()
    problem = "" if is_own_script or command[0] != str(executable) else script_problem(executable, environ)
    if problem:
        print(f"[rosrun] cannot run {executable}: {problem}", file=sys.stderr)
        return 126
    try:
        os.execvpe(command[0], command, environ)
    except OSError as error:
        print(f"[rosrun] cannot run {command[0]}: {error.strerror}", file=sys.stderr)
        return 126


def _print_executables(package: str) -> int:
    """Print the names of a package's executables. Return the exit code."""
    package_index = PackageIndex(os.environ)
    try:
        names = package_index.executables(package)
    except PackageNotFoundError:
        _print_unknown_package(package_index, package)
        return 2
    if not names:
        print(f"[rosrun] the package {package} in {package_index.find(package)} has no executables", file=sys.stderr)
        return 3
    print(*names, sep="\n")
    return 0


def _print_unknown_package(package_index: PackageIndex, package: str) -> None:
    print(f"[rospack] Error: package '{package}' not found", file=sys.stderr)
    _print_suggestion(package, package_index.list())


def _print_missing_executable(package_index: PackageIndex, package: str, executable_name: str, folder: Path) -> None:
    print(f"[rosrun] Couldn't find executable named {executable_name} below {folder}", file=sys.stderr)
    unusable_paths = package_index.find_resource(package, executable_name)
    if unusable_paths:
        print("[rosrun] Found the following, but they're either not files,", file=sys.stderr)
        print("[rosrun] or not executable:", file=sys.stderr)
        for path in unusable_paths:
            print(f"[rosrun]   {path}", file=sys.stderr)
    else:
        _print_suggestion(executable_name, package_index.executables(package))


def _print_suggestion(name: str, known_names: list[str]) -> None:
    hint = did_you_mean(name, known_names)
    if hint:
        print(f"[rosrun]{hint}", file=sys.stderr)


def _select_executable(executables: list[Path]) -> Path | None:
    """Return the executable that the user selects; None if the input ends. Without a terminal, return the first."""
    if not sys.stdin.isatty():
        return executables[0]
    print("[rosrun] You have chosen a non-unique executable, please pick one of the following:")
    for number, path in enumerate(executables, 1):
        print(f"{number}) {path}")
    while True:
        try:
            answer = input("#? ").strip()
        except EOFError:
            return None
        if answer.isdigit() and 0 < int(answer) <= len(executables):
            return executables[int(answer) - 1]


def _parse(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    options = _Options(invocation.argv)
    return options, options.args


def _print_usage(invocation: Invocation) -> int:
    from pyros1.cli.help import Parser  # noqa: PLC0415 - only needed for help

    parser = Parser(_VERB, invocation)
    print(parser.get_usage() + parser.format_epilog(parser.formatter), end="")
    return 0


_VERB = Verb(
    "",
    "",
    Option("-p", "--prefix", metavar="cmd", help="command that runs the program, for example a debugger"),
    Flag("-d", "--debug", help="print the executables that were found"),
    Argument("PACKAGE", "package"),
    Argument("EXECUTABLE", "executable"),
    Argument("ARGS", "file", repeatable=True, optional=True),
    usage="""[--prefix cmd] [--debug] PACKAGE EXECUTABLE [ARGS]
  %prog will locate PACKAGE and try to find
  an executable named EXECUTABLE in the PACKAGE tree.
  If it finds it, it will run it with ARGS.""",
    examples=[
        ("minimal_nodes minimal_publisher", "start a node"),
        ("minimal_nodes", "list the programs of a package"),
        ("my_robot driver __name:=left _port:=/dev/ttyUSB0", "start a node with a name and a private parameter"),
        ('--prefix "gdb --args" my_robot driver', "start a node in a debugger"),
    ],
    parse=_parse,
    run=run,
)

COMMAND = Command(
    "run",
    "start a node of a package",
    _VERB,
    group="run",
    stock="rosrun",
)
