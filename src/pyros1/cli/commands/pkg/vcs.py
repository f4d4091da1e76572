"""``pkg vcs`` and ``vcs0``: version control (L182)."""

from __future__ import annotations

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument
from pyros1.cli.shared.rospack.graph import graph, must_be
from pyros1.cli.shared.rospack.tool import Request, pack_verb


def _vcs(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print the version control systems of a package and its dependencies."""
    known, name = graph(request)
    must_be(known, name)
    for each in [name] if request.verb == "vcs0" else [name, *known.needs_first(name)]:
        for kind, url in known.manifest(each).version_control:
            print(f"type: {kind}\turl: {url}")


_PACKAGE = Argument("package", "package", optional=True)
VERBS = [
    pack_verb("vcs", "vcs  [package]", _PACKAGE, run=_vcs, examples=[("roscpp", "of it and its dependencies")]),
    pack_verb("vcs0", "vcs0 [package]", _PACKAGE, run=_vcs, examples=[("roscpp", "of this package only")]),
]
