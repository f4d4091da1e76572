"""``srv package`` (L88, L89)."""

from __future__ import annotations

from pyros1.cli.commands.msg.package import make_verb
from pyros1.cli.shared.definitions import SERVICES

VERB = make_verb(SERVICES, ("std_srvs", "the types of a package"))
