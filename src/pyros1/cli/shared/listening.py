"""Options for where a program listens, and who may connect to it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.records import Option

ALLOW = Option(
    "--allow",
    metavar="NETWORKS",
    own=True,
    help="who may connect besides this machine, for example 192.168.1.0/24,10.0.0.7; others are refused",
)
BIND = Option(
    "--bind",
    metavar="ADDRESS",
    own=True,
    help="address of this machine to listen on (default: all of them)",
)
PORTS = Option(
    "--ports",
    metavar="FIRST-LAST",
    own=True,
    help="ports to use besides the master's, for example 40000-40099",
)
_VARIABLES = {"allow": "PYROS1_ALLOW", "bind": "PYROS1_BIND", "ports": "PYROS1_PORTS"}


def with_options(environ: Mapping[str, str], options: Any) -> Mapping[str, str]:
    """Return the environment, with the values of given options in place of its variables.

    Args:
        environ: environment variables.
        options: values of the options above.

    Raises:
        UsageError: an option is empty: an unset variable in a script must not allow every client.
    """
    given = {variable: getattr(options, name, None) for name, variable in _VARIABLES.items()}
    for variable, value in given.items():
        if value is not None and not value.strip():
            raise UsageError(f"--{variable.removeprefix('PYROS1_').lower()} needs a value")
    return {**environ, **{variable: value for variable, value in given.items() if value is not None}}
