"""``stack depends`` and the verbs like it."""

from __future__ import annotations

from pyros1.cli.shared.rospack.graph import depends_verbs

VERBS = depends_verbs("stack", 0)
