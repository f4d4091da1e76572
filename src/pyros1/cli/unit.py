"""``pyros1 unit``: rosunit, which runs one test program without a master (L181, https://wiki.ros.org/rosunit)."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field
from optparse import OptionParser
from pathlib import Path

from pyros1 import shown
from pyros1.cli.clean_output import data_stream
from pyros1.cli.usage import Parser
from pyros1.errors import Error
from pyros1.finding.packages import package_of
from pyros1.launch.junit import Case, Results, read_results, summary, write_results
from pyros1.launch.supervisor import install_signals
from pyros1.launch.testing import results_file, results_folder
from pyros1.launch.warden import leaderless

_TIME_LIMIT = 60.0
_CASE = "runTest"
_CLASS = "rosunit.baretest.BareTestCase"
"""What the results of stock rosunit are filed under."""
_STEPS = ((signal.SIGINT, 15.0), (signal.SIGTERM, 2.0), (signal.SIGKILL, None))
"""How a program is ended: signals, and seconds to wait after each."""
_EXAMPLES = {
    "%prog test/test_math": "run a test program, results into the folder of test results",
    "%prog -t test/test_math": "results on the screen",
    "%prog --time-limit 5 --name quick test/test_math -- -v": "words behind -- are for the program",
}


class UnableError(Error):
    """A test program could not be run, or does not do what tests do.

    Args:
        text: what happened.
        failed: whether it ran at all.
    """

    def __init__(self, text: str, *, failed: bool = False) -> None:
        self.failed = failed
        super().__init__(text)


def main(argv: list[str]) -> int:
    """Run ``pyros1 unit``.

    Args:
        argv: the words after the command's name.

    Returns:
        The exit code: 0 when all is well, 1 when the program could not be run as a test, 2 when it found a failure.
    """
    parser = make_parser()
    options, words = parser.parse_args(argv)
    if not words:
        parser.error("You must supply a test file.")
    file = Path(words[0])
    name = options.test_name or file.name.rpartition(".")[0] or file.name
    place, package = package_of(file)
    if not options.package and not any((place / manifest).is_file() for manifest in ("package.xml", "manifest.xml")):
        print(f"Error: {file} is in no package; give its name with --package")
        return 1
    package = options.package or package
    try:
        folder = results_folder(os.environ)
        wrapper = results_file(folder, package, "rostest", name)
        own = results_file(folder, package, "rosunit", name)
    except Error as error:
        print(f"ERROR: {error}", file=sys.stderr)
        return 1
    run = UnitRun(file, words[1:], name, own, options.time_limit or _TIME_LIMIT, options.text)
    return _run_and_report(run, wrapper)


def make_parser() -> OptionParser:
    """Return the parser of the command's options."""
    parser: OptionParser = Parser("rosunit", "%prog [options] <file> [-- test args...]", _EXAMPLES)
    add = parser.add_option
    add("-t", "--text", action="store_true", default=False, help="write to the screen, not to XML files")
    add("--time-limit", type="float", metavar="TIME_LIMIT", help="seconds the program may take (default: 60)")
    add("--name", dest="test_name", metavar="TEST_NAME", help="name of the test (default: that of the file)")
    add("--package", metavar="PACKAGE_NAME", help="package it belongs to (default: that of the file)")
    return parser


@dataclass
class UnitRun:
    """One run of a test program.

    Args:
        file: the program; what ends in ``.py`` is given to Python.
        args: its arguments.
        name: of the test.
        path: file for its results.
        limit: seconds that it may take.
        text: it writes to the screen instead of to a file.

    Attributes:
        log: what was done, line by line.
        stopped: name of the signal that ended it, empty if none did.
        code: the program's exit code.
    """

    file: Path
    args: list[str]
    name: str
    path: Path
    limit: float = _TIME_LIMIT
    text: bool = False
    log: list[str] = field(default_factory=list)
    stopped: str = ""
    code: int = 0
    _child: subprocess.Popen[bytes] | None = None

    def run(self) -> Results:
        """Run the program to its end, at most as long as it may take.

        Returns:
            What it has found; nothing is known if it writes to the screen.

        Raises:
            UnableError: it could not be run, took too long, was interrupted, or has written no results.
        """
        self.path.unlink(missing_ok=True)
        self._say(f"Running test [{self.name}]")
        try:
            self.code = self._wait()
        except subprocess.TimeoutExpired:
            raise UnableError(f"test max time allotted: {self.limit:g} s") from None
        except OSError as error:
            raise UnableError(f"unable to launch [{self.file}]: {error.strerror}") from None
        self._say(f"test [{self.name}] finished with exit code {self.code}")
        if self.text:
            return Results()
        if not self.path.is_file():
            raise UnableError(f"test [{self.name}] did not generate test results", failed=True)
        self._say(f"test [{self.name}] results are in [{self.path}]")
        return read_results(self.path, f"{self.path.parent.name}.{self.path.stem}")

    def stop(self, reason: str) -> None:
        """End the run; callable from a signal handler in the thread that runs.

        Args:
            reason: the signal's name.
        """
        first, self.stopped = not self.stopped, self.stopped or reason
        if first and self._child is not None:
            raise UnableError(f"test [{self.name}] was interrupted by {reason}")

    def _wait(self) -> int:
        command = [*self._program(), *self.args, *(["--text"] if self.text else []), f"--gtest_output=xml:{self.path}"]
        # In a group of its own: Ctrl-C is for us, and what it starts ends with it.
        child = subprocess.Popen(command, start_new_session=True)
        try:
            self._child = child
            if self.stopped:
                raise UnableError(f"test [{self.name}] was interrupted by {self.stopped}")
            return child.wait(self.limit)
        finally:
            self._child = None
            _end(child)

    def _program(self) -> list[str]:
        file = os.path.abspath(self.file)
        if self.file.suffix != ".py":
            return [file]
        return [shutil.which("python") or shutil.which("python3") or sys.executable, file]

    def _say(self, text: str) -> None:
        self.log.append(f"[ROSUNIT]{text}\n")


def _end(child: subprocess.Popen[bytes]) -> None:
    """End a program that still runs, and what it left behind in its group."""
    for number, patience in _STEPS:
        if child.poll() is not None:
            break
        os.killpg(child.pid, number)
        with contextlib.suppress(subprocess.TimeoutExpired):
            child.wait(patience)
    if leaderless(child.pid):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child.pid, signal.SIGKILL)


def _run_and_report(run: UnitRun, wrapper: Path) -> int:
    """Run a test program; print and write down what came of it.

    Args:
        run: the program.
        wrapper: file for whether it ran.
    """
    if not run.text:
        print(f"[ROSUNIT] Outputting test results to {wrapper}", flush=True)
    case, results = Case(_CASE, _CLASS), Results()
    began = time.monotonic()
    restore = install_signals(run.stop)
    try:
        results = run.run()
    except UnableError as error:
        (case.failures if error.failed else case.errors).append((type(error).__name__, str(error)))
    finally:
        restore()
    case.seconds = time.monotonic() - began
    kind, texts = ("FAILURE", case.failures) if case.failures else ("ERROR", case.errors)
    print(f"[Testcase: {case.name}] ... {f'{kind}!' if texts else 'ok'}")
    for _, text in texts:
        print(f"{kind}: {text}\n{'-' * 80}")
    runs = Results([case])
    if run.text:
        print("WARNING: overall test result is not accurate when --text is enabled")
        return 1 if texts else 2 if run.code else 0
    try:
        write_results(wrapper, "unittest.suite.TestSuite", runs, "".join(run.log), "")
    except OSError as error:
        print(f"ERROR: cannot write {error.filename}: {error.strerror}", file=sys.stderr)
    text = summary(runs, results).replace("[ROSTEST]", "[ROSUNIT]", 1)
    print(shown.coloured_lines(text), file=data_stream())  # coloured in files and pipes, too, as stock's
    if texts:
        return 1
    return 2 if results.errors or results.failures else 0
