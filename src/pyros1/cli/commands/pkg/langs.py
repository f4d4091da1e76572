"""``pkg langs`` (L182)."""

from __future__ import annotations

import os

from pyros1.cli.invocation import Invocation
from pyros1.cli.shared.rospack.tool import Request, pack_verb, packages


def run(invocation: Invocation, request: Request, args: list[str]) -> None:
    """Print the client libraries: packages that depend on roslang, except those in ROS_LANG_DISABLE."""
    known = packages("rospack")
    disabled = os.environ.get("ROS_LANG_DISABLE", "").split(os.pathsep)
    print(" ".join(each for each in known.needed_by("roslang") if each not in disabled))


VERB = pack_verb("langs", "langs", run=run, examples=[("", "client libraries")])
