"""``pkg rosdep`` and ``rosdep0``: system dependencies (L182)."""

from __future__ import annotations

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON, Argument
from pyros1.cli.shared.rospack.graph import graph, must_be
from pyros1.cli.shared.rospack.tool import Request, pack_verb


def _rosdep(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print the system packages that a package and its dependencies need."""
    known, name = graph(request)
    must_be(known, name)
    names = [name] if request.verb == "rosdep0" else [*known.needs(name), name]
    catkin = known.manifest(name).catkin
    keys: set[str] = set()
    for each in names:
        manifest = known.manifest(each)
        keys.update(manifest.system)
        if catkin:  # rosbuild packages name rosdep keys only in manifest.xml
            keys.update(key for _, key in manifest.depends)
    request.print_names(sorted(keys) if "json" in request.options else [f"name: {key}" for key in sorted(keys)])


_PACKAGE = Argument("package", "package", optional=True)
VERBS = [
    pack_verb(
        "rosdep",
        "rosdep  [package] (alias: rosdeps)",
        JSON,
        _PACKAGE,
        aliases=["rosdeps"],
        run=_rosdep,
        examples=[("roscpp", "system packages for it and its dependencies")],
    ),
    pack_verb(
        "rosdep0",
        "rosdep0 [package] (alias: rosdeps0)",
        JSON,
        _PACKAGE,
        aliases=["rosdeps0"],
        run=_rosdep,
        examples=[("roscpp", "system packages for this package only")],
    ),
]
