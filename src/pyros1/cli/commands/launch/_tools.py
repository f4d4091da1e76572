"""The small tools that accompany the launcher: roslaunch-deps, -logs, -complete and -check (L174, L175)."""

from __future__ import annotations

import os
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import MASTER_TIMEOUT, Invocation, called_as
from pyros1.cli.parsing import leave_unparsed, parse_all_args, parse_arg_list
from pyros1.cli.records import Argument, Flag, Option, Verb
from pyros1.cli.running import run_verb
from pyros1.cli.shared.launching import print_exception
from pyros1.finding.packages import enclosing_package, files_below
from pyros1.ground.errors import Error, LaunchError, MasterError, ParameterNotSetError
from pyros1.launch.reading.cli_arguments import find_launch_files, parse_arguments
from pyros1.launch.reading.depends import FileNeeds, file_needs, find_undeclared, package_containing
from pyros1.launch.reading.loader import load_plan
from pyros1.launch.reading.resources import Resources
from pyros1.launch.reading.scope import ArgNotSetError
from pyros1.launch.reading.system_resources import make_resources
from pyros1.launch.running.check import plan_errors, python_node_errors


def run_tool(argv: list[str]) -> int:
    """Run a tool.

    Args:
        argv: the tool's name and its arguments.

    Returns:
        The exit code.
    """
    name, *args = argv
    return run_verb(TOOLS[name], Invocation(f"launch {name}", f"roslaunch-{name[2:]}", args, with_verb=False))


def _print_needed_packages(invocation: Invocation, options: Any, files: list[str]) -> int:
    """Print the packages that launch files need: ``pyros1 launch --deps``, ``roslaunch-deps``.

    Returns:
        The exit code: 1 if a file cannot be read.
    """
    if not files:
        raise UsageError("please specify a launch file")
    missing_files = [file for file in files if not os.path.exists(file)]
    if missing_files:
        raise UsageError(f"cannot locate {','.join(missing_files)}")
    try:
        _check_same_package(files)
        resources = replace(make_resources(), run_command=lambda args: "", read_bytes=_read_if_exists)
        needs_by_file: dict[str, FileNeeds] = {}
        for file in files:
            plan = load_plan([file], parse_arguments(invocation.argv), resources)
            needs_by_file.update({needs_of_file.file: needs_of_file for needs_of_file in file_needs(plan)})
            if options.verbose:
                for loaded_file in plan.files:
                    print(f"processing {'' if loaded_file == file else 'included '}launch {loaded_file}")
        if options.warn:
            print("Dependencies:")
        if options.verbose:
            _print_needs([*needs_by_file.values()])
        print(
            " ".join(
                sorted({package for needs_of_file in needs_by_file.values() for package in needs_of_file.packages})
            )
        )
        if options.warn:
            print("\nMissing declarations:")
            for package, missing_names in find_undeclared(needs_by_file.values()).items():
                if missing_names:
                    print(
                        f"{package}/manifest.xml:",
                        *(f'  <depend package="{name}" />' for name in missing_names),
                        sep="\n",
                    )
    except Error as error:
        print(error, file=sys.stderr)
        return 1
    return 0


def _read_if_exists(path: str) -> bytes:
    """Return the contents of a file; empty if it does not exist, since these tools do not use parameter values."""
    try:
        return Path(path).read_bytes()
    except FileNotFoundError:
        return b""


def _check_same_package(files: list[str]) -> None:
    packages = {package_containing(file): file for file in files}
    if len(packages) > 1:
        package_names = " vs. ".join(map(str, packages))
        raise LaunchError(f"roslaunch files must be in the same package: {package_names}")


def _print_needs(needs: list[FileNeeds]) -> None:
    for needs_of_file in needs:
        for package, executable in needs_of_file.nodes:
            print(f"{package} [{package}/{executable}]")
        if needs_of_file.package is None:
            print(f"ERROR: cannot determine package for [{needs_of_file.file}]", file=sys.stderr)
        else:
            print(f"{needs_of_file.package} [{needs_of_file.file}]")
    print("-" * 80)


def _parse_files(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    return parse_arg_list(invocation, verb, [arg for arg in invocation.argv if ":=" not in arg])


def _print_log_folder(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Print the log folder of the running master: ``pyros1 launch --logs``, ``roslaunch-logs``.

    Returns:
        The exit code: 2 if no master is running. In that case, the parent folder of all runs is printed.
    """
    if args:
        raise UsageError(f"{invocation.program} takes no arguments")
    from pyros1.launch.running.logs import log_folder  # noqa: PLC0415 - only this tool needs a master
    from pyros1.net.hosts import master_uri  # noqa: PLC0415
    from pyros1.net.master_client import MasterClient  # noqa: PLC0415

    master = MasterClient("/roslaunch", master_uri(os.environ, {}), timeout=MASTER_TIMEOUT)
    try:
        print(log_folder(os.environ) / str(master.get_param("/run_id")))
    except (MasterError, ParameterNotSetError):
        print("No active roscore", file=sys.stderr)
        print(log_folder(os.environ))
        return 2
    finally:
        master.close()
    return 0


def _print_arg_names(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Print the names of a file's arguments on one line: ``pyros1 launch --complete``, ``roslaunch-complete``.

    The command's arguments are the words typed so far: a file, or a package and a file, possibly followed by others.

    Returns:
        The exit code: 1 if the file cannot be read. In that case, nothing is printed.
    """
    resources = make_resources()
    args = [arg for arg in invocation.argv if ":=" not in arg]
    try:
        files = find_launch_files(args, resources)[:1] if args else []
        plan = load_plan(files, {}, resources, only_args=True)
    except Error:
        return 1
    print(" ".join(sorted(plan.args)))
    return 0


def _run_roslaunch_check(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Run ``roslaunch-check``, whose options differ from those of ``pyros1 launch --check``."""
    try:
        return check_package_files(args, parse_arguments(invocation.argv), options)
    except UsageError:
        raise
    except Error as error:
        print_exception(error)
        return 1


TOOLS = {
    "--deps": Verb(
        "",
        "",
        Flag("-v", "--verbose", help="print which file needs which packages"),
        Flag("-w", "--warn", help="print packages that package.xml does not declare"),
        Argument("<file(s)...>", "launch_file", repeatable=True),
        usage="[options] <file(s)...>",
        parse=_parse_files,
        run=_print_needed_packages,
    ),
    "--check": Verb(
        "",
        "",
        Option("-o", "--output-file", metavar="FILE", help="write JUnit results to FILE"),
        Flag(
            "-t",
            "--use-test-depends",
            dest="test_depends",
            help="accept <test_depend> as the declaration of a dependency",
        ),
        Flag("-i", "--ignore-unset-args", help="accept <arg>s without a value"),
        usage="[options] <file|folder> [NAME=VALUE...]",
        parse=_parse_files,
        run=_run_roslaunch_check,
    ),
    "--logs": Verb("", "", parse=parse_all_args, run=_print_log_folder),
    "--complete": Verb("", "", parse=leave_unparsed, run=_print_arg_names),
}
"""First argument, which selects a tool -> the tool."""


def check_package_files(args: list[str], arguments: dict[str, str], options: Any) -> int:
    """Check a launch file, or all those in a folder, for ``pyros1 launch --check -o`` and ``roslaunch-check``.

    With ``-o``, JUnit results are written.

    Args:
        args: the file or folder, followed by environment variables as ``NAME=VALUE``.
        arguments: values of launch arguments, given as ``name:=value`` on the command line.
        options: the parsed options; ``output_file``, ``test_depends`` and ``ignore_unset_args`` are used.

    Returns:
        The exit code: 1 if there are problems, otherwise 0.
    """
    from pyros1.launch.testing.junit import Case, Results, write_results  # noqa: PLC0415 - only this tool needs it

    if not args:
        raise UsageError("please specify a file or directory for roslaunch files to test")
    target, *variables = args
    invalid_args = [arg for arg in variables if "=" not in arg]
    if invalid_args:
        raise UsageError(f"{invalid_args[0]} is not of the form NAME=VALUE")
    if not os.path.exists(target):
        raise UsageError(f"cannot locate {target}")
    resources = make_resources()
    resources.environ = {**resources.environ, **dict(arg.split("=", 1) for arg in variables)}
    texts: list[str] = []
    for file in _launch_files(target):
        print(f"checking {file}")
        problems = _find_problems(file, arguments, resources, options)
        if problems:
            texts.append(f"[{file}]:\n\t" + "\n\t".join(problems))
    folder, package = enclosing_package(Path(target, "x") if os.path.isdir(target) else Path(target))
    relative_path = Path(target).resolve().relative_to(folder)
    case_name = "" if relative_path == Path() else re.sub(r"[/.]", "_", str(relative_path))
    if options.output_file:
        path = Path(options.output_file)
        case = Case(f"{package}_{case_name}", "roslaunch.RoslaunchCheck", 1.0)
        case.failures = [("", "\n".join([f"roslaunch check [{target}] failed", *texts]))] if texts else []
        print(f"...writing test results to {path}")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            write_results(path, path.name, Results([case]), "\n".join(texts), "")
        except OSError as error:
            raise LaunchError(f"cannot write {path}: {error.strerror}") from error
    if texts:
        print("FAILURE:", *texts, sep="\n", file=sys.stderr)
        return 1
    print("passed")
    return 0


def _launch_files(target: str) -> list[str]:
    if os.path.isfile(target):
        return [target]
    print(f"checking *.launch in directory {target}")
    paths = []
    for base, files in files_below(target):
        paths += [os.path.join(base, name) for name in files if name.endswith(".launch")]
    return paths


def _find_problems(file: str, arguments: dict[str, str], resources: Resources, options: Any) -> list[str]:
    """Return the problems with a file: errors, missing packages and executables, and undeclared dependencies."""
    errors: list[LaunchError] = []
    plan = load_plan([file], arguments, resources, problems=errors)
    if options.ignore_unset_args:
        errors = [error for error in errors if not _is_about_unset_arg(error)]
    texts = [*map(str, errors), *map(str, plan_errors(plan, resources.packages, resources.environ))]
    if not called_as("roslaunch-check"):
        texts += map(str, python_node_errors(plan, resources.packages, resources.environ))
    for package, undeclared_names in find_undeclared(file_needs(plan), test_depends=options.test_depends).items():
        if undeclared_names:
            texts.append(f"Missing package dependencies: {package}/package.xml: {', '.join(sorted(undeclared_names))}")
    return texts


def _is_about_unset_arg(error: BaseException | None) -> bool:
    while error is not None and not isinstance(error, ArgNotSetError):
        error = error.__cause__
    return error is not None
