"""``pkg export`` and ``plugins``: exports of manifests (L182)."""

from __future__ import annotations

from pyros1.cli.commands.pkg._graph import DEPS_ONLY_FLAG, check_known, packages_and_name, selected_manifests
from pyros1.cli.commands.pkg._rospack import Request, make_verb
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Option


def _export(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print the values that a package and its dependencies export for a language."""
    language, attribute = request.required_options("lang", "attrib")
    packages, name = packages_and_name(request)
    if name not in packages.by_name:
        print()
        check_known(packages, name)
    print(
        " ".join(
            value
            for manifest in selected_manifests(request, packages, name)
            for value in manifest.exported_values(language, attribute)
        )
    )


def _plugins(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print the plugins that packages export for a package."""
    (attribute,) = request.required_options("attrib")
    packages, name = packages_and_name(request)
    top = request.options.get("top", "")
    if top:
        check_known(packages, top)
    check_known(packages, name)
    allowed = {top, *packages.dependencies(top)} if top else packages.by_name.keys()
    for package in [name, *packages.dependents(name)]:
        if package in allowed:
            values = packages.manifest(package).exported_values(name, attribute)
            if values:
                print(f"{package} {values[0]}")


_ATTRIBUTE = Option("--attrib", metavar="ATTRIB", help="name of the exported attribute")
_PACKAGE = Argument("package", "package", optional=True)
VERBS = [
    make_verb(
        "export",
        "export [--deps-only] --lang=<lang> --attrib=<attrib> [package]",
        DEPS_ONLY_FLAG,
        Option("--lang", metavar="LANG", help="the language of the export"),
        _ATTRIBUTE,
        _PACKAGE,
        run=_export,
        examples=[("--lang=cpp --attrib=cflags roscpp", "print compiler flags for packages that depend on it")],
    ),
    make_verb(
        "plugins",
        "plugins --attrib=<attrib> [--top=<toppkg>] [package]",
        _ATTRIBUTE,
        Option("--top", metavar="TOPPKG", help="print only plugins of this package and its dependencies"),
        _PACKAGE,
        run=_plugins,
        examples=[("--attrib=plugin nodelet", "print plugin description files for nodelet")],
    ),
]
