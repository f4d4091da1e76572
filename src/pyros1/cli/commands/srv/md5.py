"""``srv md5`` (L88)."""

from __future__ import annotations

from pyros1.cli.commands.msg.md5 import make_verb
from pyros1.cli.shared.definitions import SERVICES

VERB = make_verb(SERVICES, ("std_srvs/SetBool", "what must be the same on both sides of a call"))
