"""rosunit, by pyros1: unit tests with results in files (https://wiki.ros.org/rosunit)."""

from __future__ import annotations

from pyros1.drop_in.module_attributes import module_getattr
from rosunit import junitxml, removed_unittest_names
from rosunit.core import XML_OUTPUT_FLAG, create_xml_runner, rostest_name_from_path, xml_results_file
from rosunit.pyunit import unitrun
from rosunit.summaries import print_runner_summary, print_unittest_summary

__getattr__ = module_getattr(__name__)

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

removed_unittest_names.restore()
