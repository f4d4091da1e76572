"""``pyros1 version``: rosversion (L180)."""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Mapping
from pathlib import Path

from pyros1 import __version__
from pyros1.cli.common import did_you_mean, print_json, program_name
from pyros1.cli.usage import examples_text
from pyros1.errors import PackageNotFoundError
from pyros1.finding.packages import PackageIndex

_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_VERSION = re.compile(r"<version[^>]*>\s*([^<\s]+)\s*</version>")
_EXAMPLES = {"%prog": "of pyros1", "%prog roscpp": "of a package", "%prog -d": "the distribution's name"}
_UNVERSIONED = "<unversioned>"


def main(argv: list[str]) -> int:
    """Run ``version``.

    Args:
        argv: the words behind.

    Returns:
        The exit code: 1 when there is no such package.
    """
    stock = program_name("rosversion") == "rosversion"
    parser = argparse.ArgumentParser(
        prog=program_name("rosversion"),
        description="Print the version of a package, the name of the ROS distribution"
        + (", or both for everything." if stock else ", or pyros1's own version."),
        formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=None if stock else examples_text("pyros1 version", _EXAMPLES).lstrip(),
    )
    parser.add_argument("-s", "--skip-newline", action="store_true", help="print no line end")
    what = parser.add_mutually_exclusive_group(required=stock)
    what.add_argument("package", nargs="?", help="name of a package, for example roscpp")
    what.add_argument("-d", "--distro", action="store_true", help="print the name of the ROS distribution")
    what.add_argument("-a", "--all", action="store_true", help="print all packages and their versions")
    parser.add_argument("--json", action="store_true", help=argparse.SUPPRESS if stock else "print JSON")
    options = parser.parse_args(argv)
    index = PackageIndex(os.environ)
    if options.all:
        versions = {name: package_version(folder) for name, folder in sorted(index.paths().items())}
        if options.json:
            print_json(versions)
            return 0
        lines = [f"{name}: {version}" for name, version in versions.items()]
    elif options.distro:
        lines = [distribution(os.environ)]
    elif options.package is None:
        lines = [f"pyros1 {__version__}"]
    else:
        try:
            lines = [package_version(index.find(options.package))]
        except PackageNotFoundError:
            print(f"Cannot locate [{options.package}]")  # where the stock tool prints it, too
            hint = did_you_mean(options.package, index.paths())
            if hint:
                print(f"{parser.prog}: there is no package {options.package}{hint}", file=sys.stderr)
            return 1
    if options.json:
        print_json(lines[0])
        return 0
    for line in lines:
        print(line, end="" if options.skip_newline else "\n")
    return 0


def package_version(folder: Path) -> str:
    """Return the version that a package's ``package.xml`` states, ``<unversioned>`` without one.

    Args:
        folder: the package's.
    """
    try:
        text = (folder / "package.xml").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return _UNVERSIONED
    match = _VERSION.search(_COMMENT.sub("", text))
    return match[1] if match else _UNVERSIONED


def distribution(environ: Mapping[str, str]) -> str:
    """Return the name of the ROS distribution: ``ROS_DISTRO``, else that of the stock installation that is found.

    Args:
        environ: environment variables.

    Returns:
        For example ``noetic``; ``Debian`` for Debian's own packages, as their rosversion says; ``<unknown>``.
    """
    if environ.get("ROS_DISTRO"):
        return environ["ROS_DISTRO"]
    installed = sorted(Path("/opt/ros").glob("*/share/roslib"), reverse=True)
    if installed:
        return installed[0].parent.parent.name
    return "Debian" if Path("/usr/share/roslib/package.xml").exists() else "<unknown>"
