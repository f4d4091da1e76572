"""``pkg export`` and ``plugins``: what manifests export (L182)."""

from __future__ import annotations

from pyros1.cli.commands.pkg._graph import DEPS_ONLY, check_known, chosen, graph
from pyros1.cli.commands.pkg._rospack import Request, pack_verb
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Option


def _export(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print what a package and its dependencies export to a language."""
    language, attribute = request.option("lang", "attrib")
    known, name = graph(request)
    if name not in known.by_name:
        print()
        check_known(known, name)
    print(" ".join(v for m in chosen(request, known, name) for v in m.exported(language, attribute)))


def _plugins(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print the plugins that packages export for a package."""
    (attribute,) = request.option("attrib")
    known, name = graph(request)
    top = request.options.get("top", "")
    if top:
        check_known(known, top)
    check_known(known, name)
    allowed = {top, *known.needs(top)} if top else known.by_name.keys()
    for each in [name, *known.needed_by(name)]:
        if each in allowed:
            values = known.manifest(each).exported(name, attribute)
            if values:
                print(f"{each} {values[0]}")


_ATTRIBUTE = Option("--attrib", metavar="ATTRIB", help="name of the exported attribute")
_PACKAGE = Argument("package", "package", optional=True)
VERBS = [
    pack_verb(
        "export",
        "export [--deps-only] --lang=<lang> --attrib=<attrib> [package]",
        DEPS_ONLY,
        Option("--lang", metavar="LANG", help="the language of the export"),
        _ATTRIBUTE,
        _PACKAGE,
        run=_export,
        examples=[("--lang=cpp --attrib=cflags roscpp", "compiler flags for its users")],
    ),
    pack_verb(
        "plugins",
        "plugins --attrib=<attrib> [--top=<toppkg>] [package]",
        _ATTRIBUTE,
        Option("--top", metavar="TOPPKG", help="only this package and its dependencies"),
        _PACKAGE,
        run=_plugins,
        examples=[("--attrib=plugin nodelet", "plugin description files for nodelet")],
    ),
]
