"""Runs the ``<test>`` tags in a launch file, each with a new master and all of the file's nodes (L186)."""

from __future__ import annotations

import io
import socket
import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from pyros1.ground.errors import Error, LaunchError
from pyros1.launch.plan import Plan, TestPlan
from pyros1.launch.reading.resources import PackageFinder
from pyros1.launch.running.command_line import locate
from pyros1.launch.running.console import Console
from pyros1.launch.running.logs import ros_home
from pyros1.launch.running.options import Options
from pyros1.launch.running.session import Session, TestAttempt
from pyros1.launch.testing.junit import Case, Results, read_results
from pyros1.net.hosts import master_uri
from pyros1.net.master_client import MasterClient

_CLASS_NAME = "rostest.runner.RosTest"
_KEPT_PARAM_PREFIXES = ("/run_id", "/rosversion", "/rosdistro", "/roslaunch/")
"""Prefixes of parameters that belong to the master and to running launchers, not to tests."""
_FILE_NAME_REPLACEMENTS = str.maketrans(dict.fromkeys(" \"'&$!`/\\", "_"))


def results_folder(environ: Mapping[str, str], base: str | None = None) -> Path:
    """Return the folder of all test results.

    Args:
        environ: environment variables; ``ROS_TEST_RESULTS_DIR`` or ``$ROS_HOME/test_results`` is used.
        base: a folder specified by the user, which takes precedence.
    """
    chosen = base or environ.get("ROS_TEST_RESULTS_DIR")
    return Path(chosen) if chosen else ros_home(environ) / "test_results"


def results_file(folder: Path, package: str, kind: str, name: str) -> Path:
    """Return the path of a result file, and create its folder.

    Args:
        folder: the folder of all test results.
        package: the package of the test.
        kind: ``rosunit`` for results that a test writes, ``rostest`` for the results of a launch file's tests.
        name: name of the test.

    Raises:
        LaunchError: the folder cannot be created.
    """
    suite_folder = folder / package
    try:
        suite_folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise LaunchError(f"cannot create test results directory [{suite_folder}]: {error.strerror}") from error
    return suite_folder / f"{kind}-{name.translate(_FILE_NAME_REPLACEMENTS)}.xml"


def name_from_path(package: Path, file: Path) -> str:
    """Return the name for a launch file's results: the file's path in the package, with ``_`` instead of slashes."""
    path = file.resolve()
    relative_path = path.relative_to(package.resolve()) if package.resolve() in path.parents else path
    return relative_path.with_suffix("").as_posix().replace("/", "_")


@dataclass
class TestRun:
    """Runs tests one after the other.

    Args:
        plan: the plan read from the launch file.
        packages: finds executables.
        environ: this process's environment.
        package: name of the package in whose folder the results are stored.
        folder: the folder of all test results.
        text: whether tests write their results to the screen instead of files.
        reuse_master: whether to use the running master.
        clear: whether to delete all parameters of the running master before each test.

    Attributes:
        runs: one case per test, which says whether the test could be run.
        results: results of the tests.
        out: stdout during the tests.
        err: stderr during the tests.
        stopped: whether `stop` was called.
    """

    __test__ = False  # not a test for pytest

    plan: Plan
    packages: PackageFinder
    environ: Mapping[str, str]
    package: str
    folder: Path
    text: bool = False
    reuse_master: bool = False
    clear: bool = False
    runs: Results = field(default_factory=Results)
    results: Results = field(default_factory=Results)
    out: io.StringIO = field(default_factory=io.StringIO)
    err: io.StringIO = field(default_factory=io.StringIO)
    stopped: bool = False
    _session: Session | None = None

    def stop(self, reason: str = "") -> None:
        """Stop the running test, and run no more. May be called in signal handlers."""
        self.stopped = True
        if self._session is not None:
            self._session.stop(reason)

    def stop_waiting(self) -> None:
        """Stop waiting for processes to exit. May be called in signal handlers."""
        if self._session is not None:
            self._session.stop_waiting()

    def run(self) -> None:
        """Run all tests, sorted by name."""
        names = [test.test_name for test in self.plan.tests]
        for _, test in sorted({test.test_name: test for test in self.plan.tests}.items()):
            if self.stopped:
                return
            case = Case(f"test{test.test_name}", _CLASS_NAME)
            started_at = time.monotonic()
            try:
                if names.count(test.test_name) > 1:
                    raise _FailedError(f"Duplicate tests named [{test.test_name}] in rostest suite")
                self._check(test)
                self._run_with_retries(test)
            except _FailedError as error:
                self._write(str(error), self.err)
                case.failures.append(("AssertionError", str(error)))
            except Error as error:
                self._write(str(error), self.err)
                case.errors.append((type(error).__name__, str(error)))
            case.seconds = time.monotonic() - started_at
            self.runs.cases.append(case)

    def _check(self, test: TestPlan) -> None:
        try:
            locate(test.package, test.type, self.packages)
        except LaunchError as error:
            raise _FailedError(
                f"Test node [{test.package}/{test.type}] does not exist or is not executable: {error}"
            ) from error

    def _run_with_retries(self, test: TestPlan) -> None:
        """Run a test until it succeeds or no retries are left."""
        for attempts_left in range(test.retry, -1, -1):
            path = results_file(self.folder, self.package, "rosunit", test.test_name)
            path.unlink(missing_ok=True)
            try:
                results = self._run_once(test, path)
            except LaunchError:
                if not attempts_left or self.stopped:
                    raise
            else:
                if self.text or not attempts_left or not (results.errors or results.failures):
                    self.results.cases += results.cases
                    return
            self._write(f"test [{test.test_name}] failed, retrying. Retries left: {attempts_left - 1}", self.out)

    def _run_once(self, test: TestPlan, path: Path) -> Results:
        attempt = TestAttempt(self._with_output_arguments(test, path), test.time_limit)
        port = None if self.reuse_master else _free_port()
        if self.reuse_master:
            self._prepare_master()
        options = Options(port=port, title="rostest")
        console = Console(self.out, self.err, title=False)
        self._session = Session(replace(self.plan, tests=[]), options, self.packages, self.environ, console)
        try:
            if not self.stopped:
                self._session.run(attempt)
        finally:
            self._session = None
        if self.stopped:
            raise LaunchError(f"test [{test.test_name}] was interrupted")
        if attempt.timed_out:
            test_type = f"{test.package}/{test.type}"
            raise LaunchError(
                f"max time [{test.time_limit}s] allotted for test [{test.test_name}] of type [{test_type}]"
            )
        if self.text:
            return Results()
        if not path.is_file():
            raise _FailedError(f"test [{test.test_name}] did not generate test results")
        results = read_results(path, f"{self.package}.{path.stem}")
        counts = f"{results.errors} errors, {results.failures} failures, {len(results.cases)} tests"
        self._write(f"test [{test.test_name}] results summary: {counts}", self.out)
        return results

    def _with_output_arguments(self, test: TestPlan, path: Path) -> TestPlan:
        arguments = [*test.args, f"--gtest_output=xml:{path}"]
        if self.text:
            return replace(test, args=[*arguments, "--text"], output="screen")
        return replace(test, args=arguments)

    def _prepare_master(self) -> None:
        master = MasterClient("/rostest", master_uri(self.environ, {}))
        try:
            master.ping()
            if self.clear:
                names = [name for name in master.get_param_names() if not name.startswith(_KEPT_PARAM_PREFIXES)]
                master.multicall([("deleteParam", (name,)) for name in names])
        finally:
            master.close()

    def _write(self, text: str, stream: io.StringIO) -> None:
        stream.write(f"[ROSTEST]{text}\n")


class _FailedError(Error):
    """A test could not be run, or has not written results."""


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("", 0))
        return int(probe.getsockname()[1])
