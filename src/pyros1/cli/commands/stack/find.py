"""``stack find``."""

from __future__ import annotations

from pyros1.cli.shared.rospack.names import find_verb

VERB = find_verb("stack")
