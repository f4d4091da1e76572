"""Runs unit tests from test programs."""

from __future__ import annotations

import sys
import unittest
from typing import Any

from pyros1.drop_in.module_attributes import module_getattr
from rosunit.core import XML_OUTPUT_FLAG, create_xml_runner
from rosunit.summaries import print_unittest_summary

__all__ = ["XML_OUTPUT_FLAG", "create_xml_runner", "print_unittest_summary", "run_suite", "unitrun"]

__getattr__ = module_getattr(
    "rosunit.pyunit",
    start_coverage="run the program with `coverage run`",
    stop_coverage="run the program with `coverage run`",
)


def unitrun(
    package: str,
    test_name: str,
    test: Any,
    sysargs: list[str] | None = None,
    coverage_packages: list[str] | None = None,
) -> None:
    """Run tests, and exit with 1 if a test fails; called at the end of a test program.

    Args:
        package: the ROS package.
        test_name: name of the results.
        test: a class of tests, or the name of a class or module.
        sysargs: the command line, with ``--text`` for text on the screen, or ``--gtest_output=xml:FILE``; None for the
            program's.
        coverage_packages: accepted for compatibility: ``--cov`` is not supported; use `coverage run`.
    """
    if not run_suite(package, test_name, test, sys.argv if sysargs is None else sysargs).wasSuccessful():
        sys.exit(1)


def run_suite(package: str, test_name: str, test: Any, words: list[str]) -> unittest.TestResult:
    """Run tests as `unitrun` does, and return the result."""
    files = [word.removeprefix(XML_OUTPUT_FLAG) for word in words if word.startswith(XML_OUTPUT_FLAG)]
    if "--cov" in words or "--covhtml" in words:
        print("WARNING: coverage is not measured: run this program with `coverage run`", file=sys.stderr)
    loader = unittest.TestLoader()
    suite = loader.loadTestsFromName(test) if isinstance(test, str) else loader.loadTestsFromTestCase(test)
    if "--text" in words:
        result: unittest.TestResult = unittest.TextTestRunner(verbosity=2).run(suite)
    else:
        result = create_xml_runner(package, test_name, files[-1] if files else None).run(suite)
    print_unittest_summary(result)
    return result
