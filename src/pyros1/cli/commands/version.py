"""``pyros1 version``: prints the versions of packages and the distribution's name, like rosversion (L180)."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pyros1 import __version__
from pyros1.cli.failures import did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON_FLAG, Argument, Command, Flag, Verb
from pyros1.cli.shared.argparsing import add_options_and_arguments, make_parser
from pyros1.cli.shared.printing import print_json
from pyros1.finding.packages import PackageIndex
from pyros1.ground.errors import PackageNotFoundError

_XML_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_VERSION_ELEMENT = re.compile(r"<version[^>]*>\s*([^<\s]+)\s*</version>")
_NO_VERSION = "<unversioned>"


_SKIP_NEWLINE = Flag("-s", "--skip-newline", help="do not print a newline")
_EXCLUSIVE_PARTS = (
    Argument("package", "package", optional=True, help="name of a package, for example roscpp"),
    Flag("-d", "--distro", help="print the name of the ROS distribution"),
    Flag("-a", "--all", help="print all packages and their versions"),
)


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Print versions or the distribution's name. Return the exit code, which is 1 if the package is unknown."""
    package_index = PackageIndex(os.environ)
    if options.all:
        versions = {name: package_version(folder) for name, folder in sorted(package_index.paths().items())}
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
            lines = [package_version(package_index.find(options.package))]
        except PackageNotFoundError:
            print(f"Cannot locate [{options.package}]")  # on stdout, like the stock tool
            hint = did_you_mean(options.package, package_index.paths())
            if hint:
                print(f"{invocation.program}: unknown package {options.package}{hint}", file=sys.stderr)
            return 1
    if options.json:
        print_json(lines[0])
        return 0
    for line in lines:
        print(line, end="" if options.skip_newline else "\n")
    return 0


def package_version(folder: Path) -> str:
    """Return the version in a package's ``package.xml``; ``<unversioned>`` if it has none.

    Args:
        folder: the folder of the package.
    """
    try:
        text = (folder / "package.xml").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return _NO_VERSION
    match = _VERSION_ELEMENT.search(_XML_COMMENT.sub("", text))
    return match[1] if match else _NO_VERSION


def distribution(environ: Mapping[str, str]) -> str:
    """Return the name of the ROS distribution, from ``ROS_DISTRO`` or the installation of stock ROS.

    Args:
        environ: the environment variables.

    Returns:
        The name, such as ``noetic``; ``Debian`` for ROS packages from Debian, as their rosversion prints; or
        ``<unknown>``.
    """
    if environ.get("ROS_DISTRO"):
        return environ["ROS_DISTRO"]
    roslib_folders = sorted(Path("/opt/ros").glob("*/share/roslib"), reverse=True)
    if roslib_folders:
        return roslib_folders[0].parent.parent.name
    return "Debian" if Path("/usr/share/roslib/package.xml").exists() else "<unknown>"


def _parse(invocation: Invocation, verb: Verb) -> tuple[Any, list[str]]:
    parser = make_parser(invocation, verb)
    parser.description = "Print the version of a package, the name of the ROS distribution" + (
        ", or all packages with their versions." if invocation.as_stock else ", or pyros1's own version."
    )
    add_options_and_arguments(parser, invocation, _SKIP_NEWLINE)
    add_options_and_arguments(
        parser.add_mutually_exclusive_group(required=invocation.as_stock), invocation, *_EXCLUSIVE_PARTS
    )
    add_options_and_arguments(parser, invocation, JSON_FLAG)
    return parser.parse_args(invocation.argv), []


COMMAND = Command(
    "version",
    "print versions of packages and the name of the distribution",
    Verb(
        "",
        "",
        _SKIP_NEWLINE,
        *_EXCLUSIVE_PARTS,
        JSON_FLAG,
        examples=[
            ("", "print pyros1's version"),
            ("roscpp", "print the version of a package"),
            ("-d", "print the distribution's name"),
        ],
        parse=_parse,
        run=run,
    ),
    group="machine",
    stock="rosversion",
)
