"""The verbs of ``srv`` (L86-L89): the same as in ``msg``, but for service types."""

from __future__ import annotations

from pyros1.cli.commands.msg import list as lists
from pyros1.cli.commands.msg import md5, show
from pyros1.cli.shared.definitions import SERVICE_KIND

VERBS = [
    *lists.make_verbs(SERVICE_KIND, "std_srvs"),
    md5.make_verb(
        SERVICE_KIND, ("std_srvs/SetBool", "print the checksum, which must be the same for client and server")
    ),
    *show.make_verbs(
        SERVICE_KIND, ("std_srvs/SetBool", "print request and response"), ("-r SetBool", "print the original text")
    ),
]
