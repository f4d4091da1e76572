"""``srv md5`` (L88)."""

from __future__ import annotations

from pyros1.cli.commands.msg.md5 import make_verb
from pyros1.cli.shared.definitions import SERVICES

VERB = make_verb(SERVICES, ("std_srvs/SetBool", "the checksum that client and server must share"))
