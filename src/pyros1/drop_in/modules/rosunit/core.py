"""Determines the paths and names of test results."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Mapping
from pathlib import Path

from pyros1.ground.errors import LaunchError
from pyros1.launch.testing.tests import results_file, results_folder
from rosunit.xmlrunner import XMLTestRunner

XML_OUTPUT_FLAG = "--gtest_output=xml:"

__all__ = [
    "XML_OUTPUT_FLAG",
    "XMLTestRunner",
    "create_xml_runner",
    "makedirs_with_parent_perms",
    "printerrlog",
    "printlog",
    "printlog_bold",
    "rostest_name_from_path",
    "xml_results_file",
]


def printlog(msg: str, *args: object) -> None:
    """Print a line, %-formatted with ``args`` if there are any."""
    print("[ROSUNIT]" + (msg % args if args else msg))


def printlog_bold(msg: str, *args: object) -> None:
    """Print a line in bold."""
    print(f"\033[1m[ROSUNIT]{msg % args if args else msg}\033[0m")


def printerrlog(msg: str, *args: object) -> None:
    """Print a line to stderr."""
    print("[ROSUNIT]" + (msg % args if args else msg), file=sys.stderr)


def makedirs_with_parent_perms(p: str) -> None:
    """Create a folder and its parents, with owner and permissions of the nearest one that exists."""
    path = Path(p).absolute()
    if path.exists():
        return
    makedirs_with_parent_perms(str(path.parent))
    parent_status = path.parent.stat()
    with contextlib.suppress(FileExistsError):
        path.mkdir()
    own_status = path.stat()
    if (own_status.st_uid, own_status.st_gid) != (parent_status.st_uid, parent_status.st_gid):
        os.chown(path, parent_status.st_uid, parent_status.st_gid)
    if own_status.st_mode != parent_status.st_mode:
        path.chmod(parent_status.st_mode)


def xml_results_file(
    test_pkg: str, test_name: str, is_rostest: bool = False, env: Mapping[str, str] | None = None
) -> str:
    """Return the path of a test's results, and create its folder.

    Args:
        test_pkg: the test's package.
        test_name: name of the test.
        is_rostest: whether the results are from a launch file's tests.
        env: environment variables; None for this process's.

    Raises:
        IOError: the folder cannot be created.
    """
    folder = results_folder(os.environ if env is None else env)
    try:
        return str(results_file(folder, test_pkg, "rostest" if is_rostest else "rosunit", test_name))
    except LaunchError as error:
        raise OSError(str(error)) from None


def rostest_name_from_path(pkg_dir: str, test_file: str) -> str:
    """Return the name of a launch file's results: its path in the package, with ``_`` instead of slashes."""
    path = os.path.abspath(test_file)
    name = path[len(pkg_dir) :].removeprefix(os.sep) if path.startswith(pkg_dir) else test_file
    name = name.replace(os.sep, "_")
    return name.rpartition(".")[0] if "." in name else name


def create_xml_runner(
    test_pkg: str, test_name: str, results_file: str | None = None, is_rostest: bool = False
) -> XMLTestRunner:
    """Return a test runner that writes its results to a file.

    Args:
        test_pkg: the test's package.
        test_name: name of the test.
        results_file: the file; None for the default one.
        is_rostest: see `xml_results_file`.

    Raises:
        IOError: the file's folder cannot be created.
    """
    path = results_file or xml_results_file(test_pkg, os.path.basename(test_name), is_rostest)
    folder = os.path.dirname(os.path.abspath(path))
    if os.path.isfile(folder):
        raise Exception(f"ERROR: cannot run test suite, file is preventing creation of test dir: {folder}")
    try:
        makedirs_with_parent_perms(folder)
    except OSError as error:
        raise OSError(f"cannot create test results directory [{folder}]: {error}") from None
    print("[ROSUNIT] Outputting test results to " + path)
    stream = open(path, "w", encoding="utf-8")  # noqa: SIM115 - the runner closes it
    stream.write('<?xml version="1.0" encoding="utf-8"?>\n')
    return XMLTestRunner(stream=stream)
