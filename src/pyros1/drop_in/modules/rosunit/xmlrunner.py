"""Runs unittest's tests, and writes their results in JUnit's format."""

from __future__ import annotations

import contextlib
import io
import sys
import time
import traceback
import unittest
from typing import IO, Any

from pyros1.launch.testing.junit import Case, Results, results_text

_LINE = "-" * 80


class _Recorder(unittest.TestResult):
    """Collects the test cases of a run, and prints the result of each."""

    def __init__(self, report: IO[str]) -> None:
        super().__init__()
        self.cases: list[Case] = []
        self._report = report
        self._started_at = 0.0
        self._problem: tuple[str, str, str] | None = None

    def startTest(self, test: unittest.TestCase) -> None:
        super().startTest(test)
        self._started_at = time.monotonic()
        self._problem = None

    def addError(self, test: unittest.TestCase, err: Any) -> None:
        super().addError(test, err)
        self._add("ERROR", err)
        if not hasattr(test, "_testMethodName"):  # an error in the set-up of a class or module: no test was started
            self.stopTest(test)

    def addFailure(self, test: unittest.TestCase, err: Any) -> None:
        super().addFailure(test, err)
        self._add("FAILURE", err)

    def addSubTest(self, test: unittest.TestCase, subtest: unittest.TestCase, err: Any) -> None:
        super().addSubTest(test, subtest, err)
        if err is not None:
            self._add("FAILURE" if issubclass(err[0], test.failureException) else "ERROR", err)

    def addUnexpectedSuccess(self, test: unittest.TestCase) -> None:
        super().addUnexpectedSuccess(test)
        self._problem = ("FAILURE", "UnexpectedSuccess", "")

    def stopTest(self, test: unittest.TestCase) -> None:
        super().stopTest(test)
        name = getattr(test, "_testMethodName", str(test))
        test_class = type(test)
        case = Case(name, f"{test_class.__module__}.{test_class.__qualname__}", time.monotonic() - self._started_at)
        self.cases.append(case)
        if self._problem is None:
            self._report.write(f"[Testcase: {name}] ... ok\n")
            return
        label, error, text = self._problem
        (case.failures if label == "FAILURE" else case.errors).append((error, text))
        self._report.write(f"[Testcase: {name}] ... {label}!\n{label}: {text}{_LINE}\n")

    def _add(self, label: str, err: Any) -> None:
        error_type, error, trace = err
        self._problem = (label, error_type.__name__, f"{error}\n" + "".join(traceback.format_tb(trace)))


class XMLTestRunner:
    """Runs tests, prints a report, and writes the results.

    Args:
        stream: a text file for the results, which is closed after writing; None for stdout.
    """

    def __init__(self, stream: IO[str] | None = None) -> None:
        self._stream = stream
        self._path = "."

    @property
    def path(self) -> str:
        """A folder; unused, kept for compatibility with stock."""
        return self._path

    @path.setter
    def path(self, path: str) -> None:
        self._path = path

    def run(self, test: unittest.TestSuite | unittest.TestCase) -> unittest.TestResult:
        """Run a test or suite, and include its output in the results. Return a unittest.TestResult."""
        out, err = io.StringIO(), io.StringIO()
        recorder = _Recorder(sys.stdout)
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            test(recorder)
        name = f"{type(test).__module__}.{type(test).__qualname__}"
        stream = self._stream or sys.stdout
        stream.write(results_text(name, Results(recorder.cases), out.getvalue(), err.getvalue()))
        if self._stream is not None:
            self._stream.close()
        return recorder
