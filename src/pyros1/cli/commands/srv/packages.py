"""``srv packages`` (L88)."""

from __future__ import annotations

from pyros1.cli.commands.msg.packages import make_verb
from pyros1.cli.shared.definitions import SERVICES

VERB = make_verb(SERVICES)
