"""rosunit, by pyros1: unit tests with results in files (https://wiki.ros.org/rosunit)."""

from __future__ import annotations

from pyros1.drop_in.missing import missing
from rosunit import junitxml, old_names
from rosunit.core import XML_OUTPUT_FLAG, create_xml_runner, rostest_name_from_path, xml_results_file
from rosunit.pyunit import unitrun
from rosunit.summaries import print_runner_summary, print_unittest_summary

__getattr__ = missing(__name__)

__all__ = [
    "XML_OUTPUT_FLAG",
    "create_xml_runner",
    "junitxml",
    "print_runner_summary",
    "print_unittest_summary",
    "rostest_name_from_path",
    "unitrun",
    "xml_results_file",
]

old_names.restore()
