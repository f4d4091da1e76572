"""``pkg export`` and ``plugins``: print what the manifests of packages export (L182)."""

from __future__ import annotations

from pyros1.cli.commands.pkg._dependencies import DEPS_ONLY_FLAG, check_known, packages_and_name, selected_manifests
from pyros1.cli.commands.pkg._rospack import Request, make_verb
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Option


def _print_exports(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print the values that a package and its dependencies export for a language."""
    language, attribute = request.required_options("lang", "attrib")
    packages, package_name = packages_and_name(request)
    if package_name not in packages.by_name:
        print()
        check_known(packages, package_name)
    print(
        " ".join(
            value
            for manifest in selected_manifests(request, packages, package_name)
            for value in manifest.exported_values(language, attribute)
        )
    )


def _print_plugins(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print the plugins for a package that this package and its dependents export."""
    (attribute,) = request.required_options("attrib")
    packages, package_name = packages_and_name(request)
    top_package = request.options.get("top", "")
    if top_package:
        check_known(packages, top_package)
    check_known(packages, package_name)
    allowed_packages = {top_package, *packages.dependencies(top_package)} if top_package else packages.by_name.keys()
    for package in [package_name, *packages.dependents(package_name)]:
        if package in allowed_packages:
            values = packages.manifest(package).exported_values(package_name, attribute)
            if values:
                print(f"{package} {values[0]}")


_ATTRIBUTE_OPTION = Option("--attrib", metavar="ATTRIB", help="name of the exported attribute")
_PACKAGE_ARGUMENT = Argument("package", "package", optional=True)
VERBS = [
    make_verb(
        "export",
        "export [--deps-only] --lang=<lang> --attrib=<attrib> [package]",
        DEPS_ONLY_FLAG,
        Option("--lang", metavar="LANG", help="the language of the export"),
        _ATTRIBUTE_OPTION,
        _PACKAGE_ARGUMENT,
        run=_print_exports,
        examples=[("--lang=cpp --attrib=cflags roscpp", "print compiler flags for packages that depend on roscpp")],
    ),
    make_verb(
        "plugins",
        "plugins --attrib=<attrib> [--top=<toppkg>] [package]",
        _ATTRIBUTE_OPTION,
        Option("--top", metavar="TOPPKG", help="print only plugins of this package and its dependencies"),
        _PACKAGE_ARGUMENT,
        run=_print_plugins,
        examples=[("--attrib=plugin nodelet", "print plugin description files for nodelet")],
    ),
]
