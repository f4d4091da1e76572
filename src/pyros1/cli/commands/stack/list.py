"""``stack list``, ``list-names`` and ``list-duplicates``."""

from __future__ import annotations

from pyros1.cli.shared.rospack_names import LIST, LIST_NAMES, list_duplicates_verb

VERBS = [LIST, LIST_NAMES, list_duplicates_verb(own=True)]
