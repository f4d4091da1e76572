"""``pkg depends`` and the verbs like it."""

from __future__ import annotations

import os

from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument
from pyros1.cli.shared.rospack.graph import depends_verbs, graph, must_be
from pyros1.cli.shared.rospack.tool import Request, pack_verb


def _generated(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print the files that rosbuild creates after it has built messages and services. catkin creates none (run)."""
    known, name = graph(request)
    if name not in known.by_name:
        print()
        must_be(known, name)
    found = []
    for each in known.needs(name):
        for kind in ("msg", "srv"):
            file = os.path.join(known.find(each).folder, f"{kind}_gen", "generated")
            if os.path.exists(file):
                found.append(file)
    print(" ".join(found))


VERBS = [
    *depends_verbs("package", 17),
    pack_verb(
        "depends-msgsrv",
        "depends-msgsrv    [package] (alias: deps-msgsrv)",
        Argument("package", "package", optional=True),
        aliases=["deps-msgsrv"],
        run=_generated,
        examples=[("roscpp", "the files that rosbuild has generated from messages")],
    ),
]
