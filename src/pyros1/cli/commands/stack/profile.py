"""``stack profile``."""

from __future__ import annotations

from pyros1.cli.shared.rospack.graph import profile_verb

VERB = profile_verb("profile [--length=<length>] ")  # stock has a space there
