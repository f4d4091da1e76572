"""Functions for test results; pyros1 has them in rosunit.core and rosunit.summaries."""

from __future__ import annotations

from typing import Any

from pyros1.drop_in.module_attributes import module_getattr
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


__getattr__ = module_getattr(
    "rosunit.baretest",
    BareTestCase="`pyros1 test` runs test programs",
    LocalProcess="`pyros1 test` runs test programs",
    TestTimeoutException="`pyros1 test` runs test programs",
    BARE_TIME_LIMIT="`pyros1 test` runs test programs",
)
