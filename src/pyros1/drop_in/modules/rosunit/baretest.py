"""Summaries of test runs."""

from __future__ import annotations

from typing import Any

from rosunit.core import (
    create_xml_runner,
    printerrlog,
    printlog,
    printlog_bold,
    rostest_name_from_path,
    xml_results_file,
)
from rosunit.summaries import print_runner_summary, print_unittest_summary

__all__ = [
    "create_xml_runner",
    "print_runner_summary",
    "print_unittest_summary",
    "printerrlog",
    "printlog",
    "printlog_bold",
    "rostest_name_from_path",
    "xml_results_file",
]


def __getattr__(name: str) -> Any:
    if name[:1].isupper():
        raise AttributeError(f"pyros1 has no rosunit.baretest.{name}: `pyros1 test` runs test programs")
    raise AttributeError(f"module 'rosunit.baretest' has no attribute {name!r}")
