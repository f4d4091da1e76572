"""Prints summaries of test runs; stock has them in rosunit.baretest."""

from __future__ import annotations

from typing import Any


def _test_names(errors: list[Any]) -> list[str]:
    return [getattr(test, "_testMethodName", None) or str(test) for test, _ in errors]


def _count_line(label: str, count: int) -> str:
    return f"\033[1;31m * {label}: {count}\033[0m" if count else f" * {label}: 0"


def _verdict(succeeded: bool) -> str:
    return "\033[32m * RESULT: SUCCESS\033[0m" if succeeded else "\033[1;31m * RESULT: FAIL\033[0m"


def print_unittest_summary(result: Any) -> None:
    """Print the summary of a unittest.TestResult."""
    succeeded = result.wasSuccessful()
    verdict = _verdict(succeeded) if succeeded else " * RESULT: FAIL"  # in colour only for success, as in stock ROS
    lines = ["-" * 61, "SUMMARY:", verdict, f" * TESTS: {result.testsRun}"]
    for label, problems in (("ERRORS", result.errors), ("FAILURES", result.failures)):
        lines.append(f" * {label}: {len(problems)} [{', '.join(_test_names(problems))}]")
    print("\n".join(lines) + "\n")


def print_runner_summary(runner_results: Any, junit_results: Any, runner_name: str = "ROSUNIT") -> None:
    """Print the summary of tests in other programs.

    Args:
        runner_results: a unittest.TestResult, which says whether the programs ran.
        junit_results: the results that the programs wrote, a `junitxml.Result`.
        runner_name: the title.
    """
    failed_to_run = _test_names(runner_results.failures)
    succeeded = runner_results.wasSuccessful() and not junit_results.num_errors + junit_results.num_failures
    lines = [
        f"[{runner_name}]{'-' * 71}\n",
        "".join(case.description for case in junit_results.test_case_results)
        + "".join(f"[{name}][failed]\n" for name in failed_to_run),
        "SUMMARY",
        _verdict(succeeded),
        f" * TESTS: {junit_results.num_tests}",
        _count_line("ERRORS", junit_results.num_errors + len(runner_results.errors)),
        _count_line("FAILURES", junit_results.num_failures + len(runner_results.failures)),
    ]
    if failed_to_run:
        lines += ["", "ERROR: The following tests failed to run:", *(f" * {name}" for name in failed_to_run)]
    print("\n".join(lines) + "\n")


def print_summary(junit_results: Any, runner_name: str = "ROSUNIT") -> None:
    """Print the summary of test results."""
    lines = [
        f"[{runner_name}]{'-' * 71}\n",
        "".join(case.description for case in junit_results.test_case_results),
        "SUMMARY",
        _verdict(not junit_results.num_errors + junit_results.num_failures),
        f" * TESTS: {junit_results.num_tests}",
        _count_line("ERRORS", junit_results.num_errors),
        _count_line("FAILURES", junit_results.num_failures),
    ]
    print("\n".join(lines) + "\n")
