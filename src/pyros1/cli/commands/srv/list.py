"""``srv list`` (L88)."""

from __future__ import annotations

from pyros1.cli.commands.msg.list import make_verb
from pyros1.cli.shared.definitions import SERVICES

VERB = make_verb(SERVICES)
