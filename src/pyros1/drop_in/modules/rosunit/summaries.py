"""Summaries of test runs; stock has them in rosunit.baretest."""

from __future__ import annotations

from typing import Any


def _named(errors: list[Any]) -> list[str]:
    return [getattr(test, "_testMethodName", None) or str(test) for test, _ in errors]


def _counted(word: str, count: int) -> str:
    return f"\033[1;31m * {word}: {count}\033[0m" if count else f" * {word}: 0"


def _verdict(good: bool) -> str:
    return "\033[32m * RESULT: SUCCESS\033[0m" if good else "\033[1;31m * RESULT: FAIL\033[0m"


def print_unittest_summary(result: Any) -> None:
    """Print the summary of a unittest.TestResult."""
    good = result.wasSuccessful()
    verdict = _verdict(good) if good else " * RESULT: FAIL"  # in colour only if it is good, like stock's
    lines = ["-" * 61, "SUMMARY:", verdict, f" * TESTS: {result.testsRun}"]
    for word, found in (("ERRORS", result.errors), ("FAILURES", result.failures)):
        lines.append(f" * {word}: {len(found)} [{', '.join(_named(found))}]")
    print("\n".join(lines) + "\n")


def print_runner_summary(runner_results: Any, junit_results: Any, runner_name: str = "ROSUNIT") -> None:
    """Print the summary of tests in other programs.

    Args:
        runner_results: a unittest.TestResult: the results of running the programs.
        junit_results: the results that they wrote, a `junitxml.Result`.
        runner_name: the title.
    """
    unable = _named(runner_results.failures)
    good = runner_results.wasSuccessful() and not junit_results.num_errors + junit_results.num_failures
    lines = [
        f"[{runner_name}]{'-' * 71}\n",
        "".join(case.description for case in junit_results.test_case_results)
        + "".join(f"[{name}][failed]\n" for name in unable),
        "SUMMARY",
        _verdict(good),
        f" * TESTS: {junit_results.num_tests}",
        _counted("ERRORS", junit_results.num_errors + len(runner_results.errors)),
        _counted("FAILURES", junit_results.num_failures + len(runner_results.failures)),
    ]
    if unable:
        lines += ["", "ERROR: The following tests failed to run:", *(f" * {name}" for name in unable)]
    print("\n".join(lines) + "\n")


def print_summary(junit_results: Any, runner_name: str = "ROSUNIT") -> None:
    """Print the summary of test results."""
    lines = [
        f"[{runner_name}]{'-' * 71}\n",
        "".join(case.description for case in junit_results.test_case_results),
        "SUMMARY",
        _verdict(not junit_results.num_errors + junit_results.num_failures),
        f" * TESTS: {junit_results.num_tests}",
        _counted("ERRORS", junit_results.num_errors),
        _counted("FAILURES", junit_results.num_failures),
    ]
    print("\n".join(lines) + "\n")
