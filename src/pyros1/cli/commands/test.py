"""``pyros1 test``: runs tests in launch files, like rostest (L186, https://wiki.ros.org/rostest/Commandline)."""

from __future__ import annotations

import os
import socket
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pyros1.cli.clean_output import data_stream
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import parse_all_args
from pyros1.cli.records import Argument, Command, Flag, Option, Verb
from pyros1.ground import terminal_text
from pyros1.ground.errors import Error

if TYPE_CHECKING:
    from pyros1.launch.testing.junit import Case
    from pyros1.launch.testing.tests import TestRun


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Run the tests of a file. Return 0 if all passed, 1 if a test could not be run, or 2 if a test failed."""
    if options.clear and not options.reuse_master:
        print("The --clear option is only valid with --reuse-master", file=sys.stderr)
        return 1
    if not args:
        raise UsageError("You must supply a test file argument to rostest.")
    return _run_file(options, args)


def _run_file(options: Any, args: list[str]) -> int:
    # The test runner is imported only if the command line is valid.
    from pyros1.cli.shared.launching import print_exception  # noqa: PLC0415
    from pyros1.finding.packages import enclosing_package  # noqa: PLC0415
    from pyros1.launch.reading.cli_arguments import CommandLineError, find_launch_files  # noqa: PLC0415
    from pyros1.launch.reading.loader import load_plan  # noqa: PLC0415
    from pyros1.launch.reading.system_resources import make_resources  # noqa: PLC0415
    from pyros1.launch.testing.junit import Case, Results, write_results  # noqa: PLC0415
    from pyros1.launch.testing.tests import TestRun, name_from_path, results_file, results_folder  # noqa: PLC0415

    resources = make_resources()
    is_missing = len(args) == 1 and not os.path.isfile(args[0])
    try:
        files = args if is_missing else find_launch_files(args, resources)
        if len(files) != 1:
            raise UsageError("rostest only accepts a single test file")
        file = Path(files[0])
        package_folder, package = enclosing_package(file)
        package_folder, package = Path(options.pkg_dir or package_folder), options.package or package
        results_name = options.results_filename or name_from_path(package_folder, file)
        results_name = results_name.rpartition(".")[0] or results_name
        folder = results_folder(os.environ, options.results_base_dir)
        results_path = results_file(folder, package, "rostest", results_name)
        if is_missing:
            message = f"rostest file [{file}] does not exist"
            write_results(
                results_path, results_name, Results([Case("test_ran", "Results", 1.0, [("", message)])]), "", ""
            )
            raise UsageError(f"test file is invalid. Generated failure case result file in {results_path}")
        plan = load_plan([str(file)], {}, resources)
        test_run = TestRun(
            plan,
            resources.packages,
            resources.environ,
            package,
            folder,
            text=options.text,
            reuse_master=bool(options.reuse_master),
            clear=bool(options.clear),
        )
        return _execute(test_run, results_path, options.text)
    except CommandLineError as error:
        raise UsageError(str(error)) from None
    except UsageError:
        raise
    except Error as error:
        print_exception(error)
        return 1


def _execute(test_run: TestRun, results_path: Path, uses_text: bool) -> int:
    from pyros1.launch.running.logs import log_folder  # noqa: PLC0415
    from pyros1.launch.running.supervisor import install_signals  # noqa: PLC0415
    from pyros1.launch.testing.junit import summary, write_results  # noqa: PLC0415

    log_path = log_folder(test_run.environ) / f"rostest-{socket.gethostname()}-{os.getpid()}.log"
    print(f"... logging to {log_path}")
    if not uses_text:
        print(f"[ROSUNIT] Outputting test results to {results_path}", flush=True)
    restore_signals = install_signals(test_run.stop, test_run.stop_waiting)
    try:
        test_run.run()
    finally:
        restore_signals()
    for case in test_run.runs.cases:
        _print_case(case)
    out, err = test_run.out.getvalue(), test_run.err.getvalue()
    try:
        log_path.parent.mkdir(parents=True, exist_ok=True)
        log_path.write_text(out + err, encoding="utf-8")
        if not uses_text:
            write_results(results_path, "unittest.suite.TestSuite", test_run.runs, out, err)
    except OSError as error:
        print(f"ERROR: cannot write {error.filename or log_path}: {error.strerror}", file=sys.stderr)
    if test_run.plan.warnings:
        print("\n[ROSTEST WARNINGS]" + "-" * 62 + "\n", file=sys.stderr)
        for warning in test_run.plan.warnings:
            print(f" * {warning}", file=sys.stderr)
    if uses_text:
        print("WARNING: overall test result is not accurate when --text is enabled")
    else:
        print()
        # As in stock ROS, the summary is coloured even in files and pipes.
        print(terminal_text.coloured_lines(summary(test_run.runs, test_run.results)), file=data_stream())
    print(f"rostest log file is in {log_path}")
    if test_run.stopped or test_run.runs.errors or test_run.runs.failures:
        return 1
    return 2 if test_run.results.errors or test_run.results.failures else 0


def _print_case(case: Case) -> None:
    """Print the result of a test."""
    verdict = "FAILURE" if case.failures else "ERROR" if case.errors else ""
    print(f"[Testcase: {case.name}] ... {f'{verdict}!' if verdict else 'ok'}")
    for _, message in [*case.failures, *case.errors]:
        print(f"{verdict}: {message}\n{'-' * 80}")


COMMAND = Command(
    "test",
    "run the tests of a launch file",
    Verb(
        "",
        "",
        Flag("-t", "--text", help="let tests write to the screen instead of XML files"),
        Option(
            "--pkgdir",
            dest="pkg_dir",
            metavar="PKG_DIR",
            help="folder of the package (default: derived from the file's location)",
        ),
        Option("--package", metavar="PACKAGE", help="name of the package (default: derived from the file's location)"),
        Option(
            "--results-filename", metavar="RESULTS_FILENAME", help="name of the results (default: the name of the file)"
        ),
        Option("--results-base-dir", metavar="RESULTS_BASE_DIR", help="folder of the results of all packages"),
        Flag("-r", "--reuse-master", help="use the running ROS master instead of starting a new one for each test"),
        Flag("-c", "--clear", help="with --reuse-master: delete all parameters of the master before each test"),
        Argument("package", "package|launch_file", optional=True),
        Argument("<filename>", "package_launch_file|launch_arg"),
        Argument("arg_name:=value", "launch_arg", repeatable=True, optional=True),
        usage="[options] [package] <filename>",
        examples=[
            ("my_robot all.test", "run the tests in a package's file"),
            ("-t all.test", "let the tests write to the screen"),
        ],
        parse=parse_all_args,
        run=run,
    ),
    group="run",
    stock="rostest",
)
