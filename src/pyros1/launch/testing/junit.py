"""Reads and writes test results in JUnit XML files (L186)."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

_NOT_XML_CHARACTER_PATTERN = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


@dataclass
class Case:
    """The result of a test case.

    Attributes:
        name: name of the case.
        classname: class or suite of the case.
        seconds: duration in seconds.
        failures: ``(type, text)`` of each failed check.
        errors: ``(type, text)`` of each error.
    """

    name: str
    classname: str = ""
    seconds: float = 0.0
    failures: list[tuple[str, str]] = field(default_factory=list)
    errors: list[tuple[str, str]] = field(default_factory=list)


@dataclass
class Results:
    """The results of one or more test programs.

    Attributes:
        cases: all test cases, in order.
        unreadable: the reason why the file could not be read, in which case ``cases`` contains only that error; empty
            if it was read.
    """

    cases: list[Case] = field(default_factory=list)
    unreadable: str = ""

    @property
    def errors(self) -> int:
        """Number of errors."""
        return sum(len(case.errors) for case in self.cases)

    @property
    def failures(self) -> int:
        """Number of failures."""
        return sum(len(case.failures) for case in self.cases)


def read_results(path: Path, suite: str) -> Results:
    """Return the results that a test program has written to a file in JUnit's or gtest's format.

    Args:
        path: path of the file.
        suite: prefix for the names of the cases.

    Returns:
        The results, which contain an error if the file cannot be read.
    """
    # Imported only after a test has run. The package has no stubs.
    from defusedxml.ElementTree import ParseError, fromstring  # type: ignore[import-untyped] # noqa: PLC0415

    try:
        root = fromstring(path.read_bytes())
        return Results(
            [
                Case(
                    f"{suite}/{element.get('name', '')}",
                    element.get("classname", ""),
                    float(element.get("time") or 0),
                    [(child.get("type", ""), _text(child)) for child in element.findall("failure")],
                    [(child.get("type", ""), _text(child)) for child in element.findall("error")],
                )
                for element in root.iter("testcase")
            ]
        )
    except (OSError, ValueError, LookupError, ParseError) as error:  # LookupError: an unknown encoding
        message = f"{path} is not a file with test results: {error}"
        return Results([Case(f"{suite}/results", errors=[("", message)])], unreadable=str(error))


def _text(element: object) -> str:
    text, message = getattr(element, "text", None), element.get("message")  # type: ignore[attr-defined]
    return (text or message or "").strip()


def write_results(path: Path, name: str, results: Results, out: str, err: str) -> None:
    """Write the results of a suite of test cases to a file.

    Args:
        path: path of the file.
        name: name of the suite.
        results: the cases of the suite.
        out: stdout during the tests.
        err: stderr during the tests.

    Raises:
        OSError: the file cannot be written.
    """
    text = '<?xml version="1.0" encoding="utf-8"?>\n' + results_text(name, results, out, err)
    path.write_text(text, encoding="utf-8")


def results_text(name: str, results: Results, out: str, err: str) -> str:
    """Return a suite of test cases as XML, without the XML declaration; see `write_results`."""
    seconds = sum(case.seconds for case in results.cases)
    lines = [
        f'<testsuite errors="{results.errors}" failures="{results.failures}" name={quoteattr(name)} '
        f'tests="{len(results.cases)}" time="{seconds:.3f}">',
    ]
    for case in results.cases:
        lines.append(
            f'<testcase classname={_quoted(case.classname)} name={_quoted(case.name)} time="{case.seconds:.4f}">'
        )
        for tag, problems in (("failure", case.failures), ("error", case.errors)):
            lines += [f"<{tag} type={_quoted(type_name)}>{_escaped(text)}</{tag}>" for type_name, text in problems]
        lines.append("</testcase>")
    lines.append(f"<system-out>{_escaped(out)}</system-out><system-err>{_escaped(err)}</system-err></testsuite>\n")
    return "\n".join(lines)


def printable(text: str) -> str:
    """Return the text with a replacement character for each character that XML cannot represent."""
    return _NOT_XML_CHARACTER_PATTERN.sub("\ufffd", text)


def _escaped(text: str) -> str:
    return escape(printable(text))


def _quoted(text: str) -> str:
    return quoteattr(printable(text))


def describe_case(case: Case) -> str:
    """Return lines that describe the result of a test case."""
    blocks = [("FAILURE", text) for _, text in case.failures] + [("ERROR", text) for _, text in case.errors]
    if not blocks:
        return f"[{case.name}][passed]\n"
    return "".join(f"{f'[{case.name}][{label}]':-<80}\n{text}\n{'-' * 80}\n\n" for label, text in blocks)


def summary(runs: Results, results: Results) -> str:
    """Return the summary to print at the end of a test run.

    Args:
        runs: one case per test program, which says whether the program could be run.
        results: results of the test programs.
    """

    def count_line(word: str, count: int) -> str:
        return f"\033[1;31m * {word}: {count}\033[0m" if count else f" * {word}: 0"

    failed_names = [case.name for case in runs.cases if case.failures or case.errors]
    errors, failures = runs.errors + results.errors, runs.failures + results.failures
    passed = not errors and not failures
    lines = [
        "".join(describe_case(case) for case in results.cases)
        + "".join(f"[{name}][failed]\n" for name in failed_names),
        "SUMMARY",
        "\033[32m * RESULT: SUCCESS\033[0m" if passed else "\033[1;31m * RESULT: FAIL\033[0m",
        f" * TESTS: {len(results.cases)}",
        count_line("ERRORS", errors),
        count_line("FAILURES", failures),
    ]
    if failed_names:
        lines += ["", "ERROR: The following tests failed to run:", *(f" * {name}" for name in failed_names)]
    return f"[ROSTEST]{'-' * 71}\n\n" + "\n".join(lines) + "\n"
