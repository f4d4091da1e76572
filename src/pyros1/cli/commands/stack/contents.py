"""``stack contents``, ``contains`` and ``contains-path``: which packages belong to which stack (L183)."""

from __future__ import annotations

import os

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument
from pyros1.cli.shared.rospack.tool import PkgError, Request, pack_verb
from pyros1.finding.crawl import all_packages


def _contents(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print the packages of a stack: those in a rosbuild stack's folder. A catkin package is a stack by itself."""
    name = request.package()
    found = all_packages(os.environ)
    stack = next((each for each in found if each.name == name and each.manifest != "manifest.xml"), None)
    if stack is None:
        raise PkgError(f"stack {name} not found", 0)
    if stack.catkin:
        request.print_names([] if stack.meta else [name])
        return
    inside = stack.folder + os.sep
    request.print_names(sorted(p.name for p in found if p.manifest == "manifest.xml" and p.folder.startswith(inside)))


def _contains(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print the name or the folder of the stack that a package belongs to."""
    name = request.package("no package given")
    found = all_packages(os.environ)
    package = next((each for each in found if each.name == name and each.manifest != "stack.xml"), None)
    stack = package if package is not None and package.catkin else None
    if package is not None and stack is None:
        above = [s for s in found if s.manifest == "stack.xml" and package.folder.startswith(s.folder + os.sep)]
        stack = max(above, key=lambda each: len(each.folder), default=None)
    if stack is None:
        raise PkgError(f"stack containing package {name} not found")
    print(stack.folder if request.verb == "contains-path" else stack.name)


VERBS = [
    pack_verb(
        "contents",
        "contents [stack]",
        Argument("stack", "package", optional=True),
        run=_contents,
        examples=[("ros_comm", "its packages")],
    ),
    pack_verb(
        "contains",
        "contains [package]",
        Argument("package", "package", optional=True),
        run=_contains,
        examples=[("roscpp", "the stack that it belongs to")],
    ),
    pack_verb(
        "contains-path",
        "contains-path [package]",
        Argument("package", "package", optional=True),
        run=_contains,
        examples=[("roscpp", "that stack's folder")],
    ),
]
