"""``srv show`` and ``srv info`` (L86)."""

from __future__ import annotations

from pyros1.cli.commands.msg.show import make_verbs
from pyros1.cli.shared.definitions import SERVICES

VERBS = make_verbs(
    SERVICES,
    ("std_srvs/SetBool", "request and response"),
    ("-r SetBool", "the original text"),
)
