"""Results of tests in JUnit's XML format, as rosunit writes and reads them (https://wiki.ros.org/rosunit)."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from typing import Any
from xml.etree import ElementTree as ET

import rospkg
from defusedxml.common import DefusedXmlException  # type: ignore[import-untyped]
from defusedxml.ElementTree import fromstring  # type: ignore[import-untyped]

from pyros1.drop_in.module_attributes import module_getattr
from rosunit.summaries import print_summary

__getattr__ = module_getattr(
    "rosunit.junitxml",
    DomNode="use xml.dom.Node",
    StringIO="use io.StringIO",
    char="use chr",
    codecs="import it",
    parseString="use xml.dom.minidom.parseString",
    print_function="Python 3 does not need it",
    reduce="use functools.reduce",
)

python2 = False
pattern = "[^\t\n\r -~\x85\xa0-\xff\u0100-\ud7ff\ue000-\ufdcf\ufde0-\ufffd]"
invalid_chars = re.compile(pattern)
"""Characters that XML cannot contain, in text that is written."""
RE_XML_ILLEGAL = (
    "([\x00-\x08\x0b-\x0c\x0e-\x1f\ufffe-\uffff])|([\ud800-\udbff][^\udc00-\udfff])|([^\ud800-\udbff][\udc00-\udfff])"
    "|([\ud800-\udbff]$)|(^[\udc00-\udfff])"
)
"""Characters that XML cannot contain, in files that are read: they become "?"."""
_illegal = re.compile(RE_XML_ILLEGAL)
_WIDTH = 80


def invalid_char_replacer(m: re.Match[str]) -> str:
    """Return the XML character reference for a regex match."""
    return f"&#x{ord(m.group(0)):04X};"


def filter_nonprintable_text(text: str) -> str:
    """Return a string in which characters that XML cannot contain are replaced with character references."""
    return invalid_chars.sub(invalid_char_replacer, text)


def cdata(cdata_text: str) -> str:
    """Return a string as a CDATA section."""
    return f"<![CDATA[\n{cdata_text}\n]]>"


def _make_text_element(tag: str, text: str, **attributes: str) -> ET.Element:
    element = ET.Element(tag, attributes)
    element.text = filter_nonprintable_text(cdata(text))
    return element


def _make_rule(name: str, label: str) -> str:
    return f"[{name}]{label}".ljust(_WIDTH, "-")


class TestInfo:
    """The reason why a test did not succeed.

    Args:
        type_: kind of problem, for example the name of an exception.
        text: a human-readable description.
    """

    __test__ = False  # not a test class for pytest

    def __init__(self, type_: str, text: str) -> None:
        self.type = type_
        self.text = text


class TestError(TestInfo):
    """A test could not be run."""

    def xml_element(self) -> ET.Element:
        """Return the XML element."""
        return _make_text_element("error", self.text, type=self.type)

    def xml(self) -> bytes:
        """Return the XML in UTF-8."""
        return ET.tostring(self.xml_element(), encoding="utf-8")


class TestFailure(TestInfo):
    """An assertion of a test failed."""

    def xml_element(self) -> ET.Element:
        """Return the XML element."""
        return _make_text_element("failure", self.text, type=self.type)

    def xml(self) -> bytes:
        """Return the XML in UTF-8."""
        return ET.tostring(self.xml_element(), encoding="utf-8")


class TestCaseResult:
    """Result of one test.

    Attributes:
        name, classname: name and class of the test.
        time: duration in seconds.
        failures, errors: why the test did not succeed.
    """

    __test__ = False

    def __init__(self, name: str) -> None:
        self.name = name
        self.failures: list[Any] = []
        self.errors: list[Any] = []
        self.time = 0.0
        self.classname = ""

    @property
    def passed(self) -> bool:
        """Whether the test has succeeded."""
        return not self.errors and not self.failures

    @property
    def description(self) -> str:
        """A human-readable description of the result."""
        if self.passed:
            return f"[{self.name}][passed]\n"
        parts = [("[FAILURE]", problem.text) for problem in self.failures] + [
            ("[ERROR]", problem.text) for problem in self.errors
        ]
        return "".join(f"{_make_rule(self.name, what)}\n{text}\n{'-' * _WIDTH}\n\n" for what, text in parts)

    def add_failure(self, failure: Any) -> None:
        """Add a `TestFailure`."""
        self.failures.append(failure)

    def add_error(self, error: Any) -> None:
        """Add a `TestError`."""
        self.errors.append(error)

    def xml_element(self) -> ET.Element:
        """Return the XML element."""
        element = ET.Element("testcase", {"classname": self.classname, "name": self.name, "time": str(self.time)})
        element.extend(problem.xml_element() for problem in (*self.failures, *self.errors))
        return element

    def xml(self) -> bytes:
        """Return the XML in UTF-8."""
        return ET.tostring(self.xml_element(), encoding="utf-8")


class Result:
    """Results of several tests.

    Attributes:
        name: name of the suite.
        num_errors, num_failures, num_tests: as counted by the runner.
        test_case_results: result of each test.
        system_out, system_err: what the tests printed.
        time: duration in seconds.
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
        self.test_case_results: list[Any] = []
        self.system_out = ""
        self.system_err = ""
        self.time = 0.0

    def accumulate(self, r: Any) -> None:
        """Add another result to this one."""
        self.num_errors += r.num_errors
        self.num_failures += r.num_failures
        self.num_tests += r.num_tests
        self.time += r.time
        self.test_case_results.extend(r.test_case_results)
        if r.system_out:
            self.system_out += "\n" + r.system_out
        if r.system_err:
            self.system_err += "\n" + r.system_err

    def add_test_case_result(self, r: Any) -> None:
        """Add the result of a test; the counts are not changed."""
        self.test_case_results.append(r)

    def xml_element(self) -> bytes:
        """Return the XML in UTF-8, like stock, despite the name."""
        element = _make_suite(self.name, self.num_tests, self.num_failures, self.time, self.num_errors)
        element.extend(case.xml_element() for case in self.test_case_results)
        element.append(_make_text_element("system-out", self.system_out))
        element.append(_make_text_element("system-err", self.system_err))
        return ET.tostring(element, encoding="utf-8")


def _make_suite(name: str, tests: int, failures: int, time: float, errors: int = 0) -> ET.Element:
    counts = {"tests": tests, "failures": failures, "time": time, "errors": errors}
    return ET.Element("testsuite", {key: str(count) for key, count in counts.items()} | {"name": name})


def _add_test(suite: ET.Element, class_name: str, testcase_name: str) -> ET.Element:
    return ET.SubElement(
        suite, "testcase", {"name": testcase_name, "status": "run", "time": "1", "classname": class_name}
    )


def test_failure_junit_xml(
    test_name: str,
    message: str,
    stdout: str | None = None,
    class_name: str = "Results",
    testcase_name: str = "test_ran",
) -> bytes:
    """Return the XML, in UTF-8, of a suite with one test that has failed.

    Args:
        test_name: name of the suite.
        message: why the test failed.
        stdout: what the test printed.
        class_name, testcase_name: class and name of the test.
    """
    suite = _make_suite(test_name, 1, 1, 1)
    ET.SubElement(_add_test(suite, class_name, testcase_name), "failure", {"message": message, "type": ""})
    if stdout:
        suite.append(_make_text_element("system-out", stdout))
    return ET.tostring(suite, encoding="utf-8")


def test_success_junit_xml(test_name: str, class_name: str = "Results", testcase_name: str = "test_ran") -> bytes:
    """Return the XML, in UTF-8, of a suite with one test that has succeeded."""
    suite = _make_suite(test_name, 1, 0, 1)
    _add_test(suite, class_name, testcase_name)
    return ET.tostring(suite, encoding="utf-8")


test_failure_junit_xml.__test__ = test_success_junit_xml.__test__ = False  # type: ignore[attr-defined]  # not tests for pytest


def read(test_file: str, test_name: str) -> Result:
    """Read a result file; if it cannot be read, print a warning to stdout and return no results.

    Args:
        test_file: path of the file. Characters that XML cannot contain are replaced in the file.
        test_name: name of the result, and prefix of the classes of its tests.

    Raises:
        ValueError: a count in the file is not a number.
    """
    result = Result(test_name)
    if not os.path.isfile(test_file):
        print(f"WARN: cannot read test result file [{test_file}]: test file does not exist")
        return result
    try:
        if os.path.getsize(test_file) == 0:
            print(f"WARN: test result file is empty [{test_file}]")
            return result
        root = fromstring(_read_cleaned(test_file))
    except (ET.ParseError, DefusedXmlException, OSError) as error:
        print(f"WARN: cannot read test result file [{test_file}]: {error}")
        return result
    suites = [root] if root.tag == "testsuite" else root.findall("testsuite") if root.tag == "testsuites" else []
    if not suites:
        print(f"WARN: test result file [{test_file}] contains no results")
    folder, name = os.path.split(os.path.abspath(test_file))
    display_name = f"{os.path.basename(folder)}.{os.path.splitext(name.removeprefix('TEST-'))[0]}"
    for suite in suites:
        result.accumulate(_load(suite, test_name, display_name))
    return result


def _read_cleaned(test_file: str) -> bytes:
    """Return a file's bytes as UTF-8, with "?" for characters that XML cannot contain; rewrite the file if that changes
    it.
    """
    with open(test_file, "rb") as file:
        content = file.read()
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    clean = _illegal.sub("?", text).encode("utf-8")
    if clean != content:
        with open(test_file, "wb") as file:
            file.write(clean)
    return clean


def _load(suite: ET.Element, test_name: str, display_name: str) -> Result:
    counts = (int(suite.get(key) or 0) for key in ("errors", "failures", "tests"))
    result = Result(test_name, *counts)
    result.time = _seconds(suite)
    _fill(result, suite, display_name)
    return result


def _fill(result: Result, suite: ET.Element, display_name: str) -> None:
    """Add the results of a suite and of the suites in it; the counts in the file are ignored."""
    for element in suite:
        if element.tag == "testcase":
            result.add_test_case_result(_case(element, result.name, display_name))
        elif element.tag == "testsuite":
            _fill(result, element, display_name)
        elif element.tag == "system-out" and _text(element):
            result.system_out += f"{_make_rule(display_name, ' stdout')}\n{_text(element)}"
        elif element.tag == "system-err" and _text(element):
            result.system_err += f"{_make_rule(display_name, ' stderr')}\n{_text(element)}"


def _case(element: ET.Element, test_name: str, display_name: str) -> TestCaseResult:
    case = TestCaseResult(f"{display_name}/{element.get('name') or 'unknown'}")
    case.classname = f"{test_name}.{element.get('classname') or 'unknown'}"
    case.time = _seconds(element)
    case.failures = [TestFailure(problem.get("type", ""), _text(problem)) for problem in element.findall("failure")]
    case.errors = [TestError(problem.get("type", ""), _text(problem)) for problem in element.findall("error")]
    return case


def _text(element: ET.Element) -> str:
    return "".join(element.itertext()).strip()


def _seconds(element: ET.Element) -> float:
    try:
        return float(element.get("time") or 0.0)
    except ValueError:
        return 0.0


def read_all(filter_: Iterable[str] = ()) -> Result:
    """Read the result files of all packages, which are in subfolders of the folder for ROS's test results.

    Args:
        filter_: names of packages; empty for all.
    """
    total = Result("ros")
    top = rospkg.get_test_results_dir()
    for package in sorted(os.listdir(top)):
        folder = os.path.join(top, package)
        if (filter_ and package not in filter_) or not os.path.isdir(folder):
            continue
        for name in sorted(os.listdir(folder)):
            if name.endswith(".xml"):
                total.accumulate(read(os.path.join(folder, name), package))
    return total
