"""Code shared by the verbs of ``bridge`` that listen or connect: options, files and keys."""

from __future__ import annotations

import sys
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pyros1.cli.failures import CommandError
from pyros1.cli.records import Flag, Option
from pyros1.ground.terminal_text import one_line

if TYPE_CHECKING:
    from pyros1.bridge.rules.site_access import SiteAccess
    from pyros1.bridge.transport.certificates import SiteKeys

_MAX_FILE_SIZE = 1 << 20
CONNECT_OPTION = Option(
    "--to",
    dest="connect",
    action="append",
    default=[],
    metavar="ENDPOINT",
    help="where another site listens, for example tls/base.example:7447; may be repeated",
)
LISTEN_OPTION = Option(
    "--listen",
    action="append",
    default=[],
    metavar="ENDPOINT",
    help="where to listen for other sites, for example tls/[::]:7447; may be repeated",
)
SITES_OPTION = Option(
    "--sites",
    nargs="+",
    action="append",
    default=[],
    metavar="NAME",
    help="talk only to these sites; if this site listens with --keys, only they are let in, and none can "
    "impersonate another. red-2 instead of red lets in red only with these newer keys",
)
INSECURE_FLAG = Flag(
    "--insecure",
    help="use unencrypted endpoints beyond this machine, although anybody who can reach them can read what is sent, "
    "and send",
)


def read_file(name: str) -> str:
    """Return the text of a file.

    Raises:
        CommandError: the file is too long, or not text.
        OSError: the file cannot be read.
    """
    with open(name, "rb") as file:
        text = file.read(_MAX_FILE_SIZE + 1)
    if len(text) > _MAX_FILE_SIZE:
        raise CommandError(f"{one_line(name)} has more than {_MAX_FILE_SIZE >> 20} MB", 2)
    try:
        return text.decode()
    except UnicodeDecodeError as error:
        line = text.count(b"\n", 0, error.start) + 1
        raise CommandError(f"{one_line(name)}:{line}: this is not UTF-8 text; save the file as UTF-8", 2) from None


def beside(name: str, file: str) -> str:
    """Return a path that is relative to a file's folder, as one relative to the working directory; absolute paths
    stay."""
    return str(Path(file).parent / Path(name).expanduser())


def check_connections(
    connect: Sequence[str],
    listen: Sequence[str],
    keys: str,
    access: Collection[SiteAccess],
    insecure: bool,
    places: Mapping[str, str],
) -> None:
    """Refuse invalid or insecure endpoints, and access limits that could not be enforced.

    Args:
        connect, listen: endpoints to connect to, and endpoints to listen on.
        keys: the folder of the keys; empty for none.
        access: what other sites may do.
        insecure: whether unencrypted endpoints beyond this machine are allowed.
        places: file and line, by endpoint and by key name.

    Raises:
        EndpointError, RulesError: an endpoint or a limit is refused.
    """
    from pyros1.bridge.rules.file_reader import RulesError  # noqa: PLC0415
    from pyros1.bridge.transport.endpoints import (  # noqa: PLC0415
        EndpointError,
        check_endpoint,
        check_reachable,
        check_security,
    )

    for endpoint in dict.fromkeys((*connect, *listen)):
        try:
            check_endpoint(endpoint)
            is_far, is_own = endpoint in connect, endpoint in listen
            check_security([endpoint] * is_far, [endpoint] * is_own, bool(keys), insecure)
            if is_far:
                check_reachable(endpoint)
        except EndpointError as error:
            raise EndpointError(_at(places.get(endpoint), error)) from None
    limited = [each.keys for each in access if each.is_limited or each.forwards or each.keys != each.site]
    if limited and not (listen and keys):
        missing = "needs keys, which prove the names of sites" if listen else "applies only where other sites connect"
        problem = f"what `sites` says about {limited[0]} {missing}: give {'--keys' if listen else '--listen'}"
        raise RulesError(_at(places.get(limited[0]), problem))


def _at(place: str | None, problem: object) -> str:
    return f"{place}: {problem}" if place else str(problem)


def read_keys(folder: str) -> SiteKeys:
    """Return the keys in a folder, and warn if they expire soon.

    Raises:
        KeysError: the keys cannot be used.
    """
    from pyros1.bridge.transport.certificates import EXPIRY_WARNING_DAYS, load_keys  # noqa: PLC0415

    keys = load_keys(Path(folder).expanduser())
    if (days := keys.days_left()) < EXPIRY_WARNING_DAYS:
        when = f"in {days} day{'s' * (days != 1)}" if days else "today"
        print(f"WARNING: the keys in {one_line(folder)} expire {when}", file=sys.stderr)
    return keys


def make_security(
    keys: SiteKeys, connect: Sequence[str], listen: Sequence[str], access: Collection[SiteAccess], own_site: str = ""
) -> Mapping[str, str]:
    """Return zenoh's settings for keys and access control, and warn about what they leave unprotected.

    Args:
        keys: the keys.
        connect, listen: endpoints to connect to, and endpoints to listen on.
        access: what other sites may do.
        own_site: the name of this site; empty for a standalone router.
    """
    from pyros1.bridge.transport.access_control import security_settings  # noqa: PLC0415

    if listen and not access:
        print(
            "WARNING: no sites are named with --sites, so any site with keys can impersonate another one here",
            file=sys.stderr,
        )
    if listen and connect and access and not any(each.forwards for each in access):
        print(
            f"WARNING: no site in `sites` forwards others, so only sites are heard that connect here or listen on "
            f"{', '.join(map(one_line, connect))}, and none behind them",
            file=sys.stderr,
        )
    # If a site only connects, all other sites' packets come under the certificate of the one that it connects to.
    return security_settings(keys, access if listen else (), own_site)
