"""Options for the address and ports on which a program listens, and for the clients that may connect."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.records import Option

ALLOW_OPTION = Option(
    "--allow",
    metavar="NETWORKS",
    pyros1_only=True,
    help="networks or addresses that may connect besides this machine, for example 192.168.1.0/24,10.0.0.7",
)
BIND_OPTION = Option(
    "--bind",
    metavar="ADDRESS",
    pyros1_only=True,
    help="address of this machine to listen on (default: all)",
)
PORTS_OPTION = Option(
    "--ports",
    metavar="FIRST-LAST",
    pyros1_only=True,
    help="range of ports to listen on, in addition to the master's port, for example 40000-40099",
)
_VARIABLES_BY_OPTION = {"allow": "PYROS1_ALLOW", "bind": "PYROS1_BIND", "ports": "PYROS1_PORTS"}


def with_listen_options(environ: Mapping[str, str], options: Any) -> Mapping[str, str]:
    """Return the environment, with variables set from the options of this module that were given.

    Args:
        environ: the environment variables.
        options: the parsed options.

    Raises:
        UsageError: an option has an empty value. Otherwise, a script with an unset variable, as in
            ``--allow "$NETWORKS"``, would admit all clients.
    """
    values_by_variable = {variable: getattr(options, name, None) for name, variable in _VARIABLES_BY_OPTION.items()}
    for variable, value in values_by_variable.items():
        if value is not None and not value.strip():
            raise UsageError(f"--{variable.removeprefix('PYROS1_').lower()} needs a value")
    return {**environ, **{variable: value for variable, value in values_by_variable.items() if value is not None}}
