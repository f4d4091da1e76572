"""``pkg list``, ``list-names`` and ``list-duplicates``."""

from __future__ import annotations

from pyros1.cli.shared.rospack.names import list_verbs

VERBS = list_verbs(duplicates=True)
