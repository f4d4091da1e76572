"""Test results in JUnit's format."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

from pyros1.launch.testing.junit import Case, description, read_results
from pyros1.launch.testing.tests import results_folder
from rosunit.summaries import print_summary

__all__ = [
    "Result",
    "TestCaseResult",
    "TestError",
    "TestFailure",
    "TestInfo",
    "cdata",
    "filter_nonprintable_text",
    "print_summary",
    "read",
    "read_all",
    "test_failure_junit_xml",
    "test_success_junit_xml",
]


python2 = False
RE_XML_ILLEGAL = "[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]"
"""Pattern of the characters that XML cannot hold."""
pattern = "[^\t\n\r -~\x85\xa0-\xff\u0100-\ud7ff\ue000-\ufdcf\ufde0-\ufffd]"
"""Pattern of the characters that stand as numbers in results."""


def invalid_char_replacer(m: re.Match[str]) -> str:
    """Return what stands for a character that was found."""
    return f"&#x{ord(m[0]):04X};"


def cdata(cdata_text: str) -> str:
    """Return a text as a CDATA section."""
    return f"<![CDATA[\n{cdata_text}\n]]>"


def filter_nonprintable_text(text: str) -> str:
    """Return a text with numbers, as ``&#x001B;``, in place of characters that XML cannot hold, or should not."""
    return re.sub(pattern, invalid_char_replacer, text)


class TestInfo:
    """What a test has found.

    Attributes:
        type: the exception's name. text: its text.
    """

    __test__ = False
    tag = ""

    def __init__(self, type_: str, text: str) -> None:
        self.type = type_
        self.text = text

    def xml_element(self) -> ET.Element:
        """Return it as an XML element."""
        element = ET.Element(self.tag, {"type": self.type})
        element.text = cdata(filter_nonprintable_text(self.text))
        return element

    def xml(self) -> bytes:
        """Return it as XML, in UTF-8."""
        return bytes(ET.tostring(self.xml_element(), encoding="utf-8", method="xml"))


class TestError(TestInfo):
    """A test could not be run to its end."""

    tag = "error"


class TestFailure(TestInfo):
    """A check failed."""

    tag = "failure"


class TestCaseResult:
    """Result of one test.

    Attributes:
        name, classname: of the test. time: seconds. failures, errors: what was found.
    """

    __test__ = False

    def __init__(self, name: str) -> None:
        self.name = name
        self.classname = ""
        self.time = 0.0
        self.failures: list[Any] = []
        self.errors: list[Any] = []

    @property
    def passed(self) -> bool:
        """Whether nothing was found."""
        return not self.failures and not self.errors

    @property
    def description(self) -> str:
        """The result as text for a summary."""
        found = [[(each.type, each.text) for each in some] for some in (self.failures, self.errors)]
        return description(Case(self.name, failures=found[0], errors=found[1]))

    def add_failure(self, failure: Any) -> None:
        """Add a TestFailure."""
        self.failures.append(failure)

    def add_error(self, error: Any) -> None:
        """Add a TestError."""
        self.errors.append(error)

    def xml_element(self) -> ET.Element:
        """Return it as an XML element."""
        element = ET.Element("testcase", {"classname": self.classname, "name": self.name, "time": str(self.time)})
        element.extend(each.xml_element() for each in (*self.failures, *self.errors))
        return element

    def xml(self) -> bytes:
        """Return it as XML, in UTF-8."""
        return bytes(ET.tostring(self.xml_element(), encoding="utf-8", method="xml"))


class Result:
    """Results of several tests.

    Attributes:
        name: of the suite. num_errors, num_failures, num_tests: numbers. test_case_results: each test.
        time: seconds. system_out, system_err: what the tests printed.
    """

    __slots__ = [
        "name",
        "num_errors",
        "num_failures",
        "num_tests",
        "system_err",
        "system_out",
        "test_case_results",
        "time",
    ]

    def __init__(self, name: str, num_errors: int = 0, num_failures: int = 0, num_tests: int = 0) -> None:
        self.name = name
        self.num_errors = num_errors
        self.num_failures = num_failures
        self.num_tests = num_tests
        self.test_case_results: list[TestCaseResult] = []
        self.system_out = ""
        self.system_err = ""
        self.time = 0.0

    def accumulate(self, r: Result) -> None:
        """Add other results."""
        self.num_errors += r.num_errors
        self.num_failures += r.num_failures
        self.num_tests += r.num_tests
        self.time += r.time
        self.test_case_results.extend(r.test_case_results)
        self.system_out += "\n" + r.system_out if r.system_out else ""
        self.system_err += "\n" + r.system_err if r.system_err else ""

    def add_test_case_result(self, r: TestCaseResult) -> None:
        """Add the result of a test; the numbers stay as they are."""
        self.test_case_results.append(r)

    def xml_element(self) -> ET.Element:
        """Return them as an XML element."""
        numbers = {"tests": self.num_tests, "failures": self.num_failures, "time": self.time, "errors": self.num_errors}
        element = ET.Element("testsuite", {**{key: str(value) for key, value in numbers.items()}, "name": self.name})
        element.extend(each.xml_element() for each in self.test_case_results)
        for tag, text in (("system-out", self.system_out), ("system-err", self.system_err)):
            if text:
                ET.SubElement(element, tag).text = cdata(filter_nonprintable_text(text))
        return element


def read(test_file: str, test_name: str) -> Result:
    """Return the results in a file; none, and a printed warning, if it cannot be read."""
    path = Path(test_file).absolute()
    found = read_results(path, f"{path.parent.name}.{path.name.removeprefix('TEST-').removesuffix('.xml')}")
    if found.unreadable:
        print(f"WARN: cannot read test result file [{test_file}]: {found.unreadable}")
        return Result(test_name)
    result = Result(test_name, found.errors, found.failures, len(found.cases))
    for case in found.cases:
        one = TestCaseResult(case.name)
        one.classname, one.time = f"{test_name}.{case.classname}", case.seconds
        one.failures = [TestFailure(*each) for each in case.failures]
        one.errors = [TestError(*each) for each in case.errors]
        result.add_test_case_result(one)
        result.time += case.seconds
    return result


def read_all(filter_: Any = ()) -> Result:
    """Return all results below the folder of test results, or only those of some packages."""
    total = Result("ros")
    folder = results_folder(os.environ)
    for place in sorted(folder.iterdir()) if folder.is_dir() else []:
        if place.is_dir() and (not filter_ or place.name in filter_):
            for file in sorted(place.glob("*.xml")):
                total.accumulate(read(str(file), place.name))
    return total


def _one_case(test_name: str, class_name: str, testcase_name: str, failures: int) -> tuple[ET.Element, ET.Element]:
    suite = ET.Element(
        "testsuite", {"tests": "1", "failures": str(failures), "time": "1", "errors": "0", "name": test_name}
    )
    case = {"name": testcase_name, "status": "run", "time": "1", "classname": class_name}
    return suite, ET.SubElement(suite, "testcase", case)


def test_failure_junit_xml(
    test_name: str,
    message: str,
    stdout: str | None = None,
    class_name: str = "Results",
    testcase_name: str = "test_ran",
) -> bytes:
    """Return the results of a suite whose only test failed, as XML in UTF-8.

    Args:
        test_name: name of the suite.
        message: why.
        stdout: what was printed.
        class_name, testcase_name: of the test.
    """
    suite, case = _one_case(test_name, class_name, testcase_name, 1)
    ET.SubElement(case, "failure", {"message": message, "type": ""})
    if stdout:
        ET.SubElement(suite, "system-out").text = cdata(filter_nonprintable_text(stdout))
    return bytes(ET.tostring(suite, encoding="utf-8", method="xml"))


def test_success_junit_xml(test_name: str, class_name: str = "Results", testcase_name: str = "test_ran") -> bytes:
    """Return the results of a suite whose only test succeeded, as XML in UTF-8."""
    return bytes(ET.tostring(_one_case(test_name, class_name, testcase_name, 0)[0], encoding="utf-8", method="xml"))
