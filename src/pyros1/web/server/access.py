"""Decides who may connect (by machine, token, Host and Origin headers), and what pages may see and change (no I/O).

A page from another site that is open in the same browser can send requests to this server, even under its own name, by
DNS rebinding. But such a page does not know the token, and cannot send one of this server's names as Host.
"""

from __future__ import annotations

import hmac
import ipaddress
import re
import secrets
from collections.abc import Collection, Container, Iterable
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import parse_qs, urlsplit

from pyros1.web.server.wire import RequestError

if TYPE_CHECKING:
    from pyros1.net.allowlist import Allowlist

MAX_PAGES = 64
LOOPBACK = frozenset({"localhost", "127.0.0.1", "::1"})
_HOST_PATTERN = re.compile(
    r"(?:\[(?P<six>[0-9A-Fa-f:.]+)\]|(?P<name>[A-Za-z0-9._-]+))(?::(?P<port>\d{1,5}))?\Z", re.ASCII
)


_STALE_TOKEN = "This link is from an earlier run of the server: pyros1 web creates a new token each time it starts."
_MISSING_TOKEN = "This link lacks its token."
_TOKEN_HINT = (
    "Use the link that the server printed, or run `pyros1 web graph`, which opens the page. "
    "Links stay valid if the server is started with --token and a secret of your own."
)


@dataclass(frozen=True)
class Access:
    """The access rules of one server.

    Attributes:
        token: the token that links must contain; empty if they need none.
        names: the server's names and addresses, in addition to those of loopback.
        any_address: whether every IP address is accepted as the server's, since the server listens on all interfaces.
        read_only: whether pages must not change anything.
        origins: other sites whose pages may connect (with the token, if there is one), such as
            ``http://localhost:8000``.
        topics: patterns such as ``/camera/*`` for the topics, services and parameters that pages may see; empty for
            all.
        services, parameters: patterns for services and for parameters, in place of ``topics``; None to use ``topics``.
        allowlist: decides which machines may connect; None for all machines that can reach the server.
        max_pages: maximum number of connected pages, programs and viewers.
        bags: folders whose bags pages may see, and into which they may record; also single bags that pages may see.
        granted: bags that pages may also see, added while the server runs; see `pyros1.web.bags.granted_files`.
    """

    token: str = field(default_factory=lambda: secrets.token_urlsafe(16), repr=False)
    names: Collection[str] = ()
    any_address: bool = False
    read_only: bool = False
    topics: tuple[str, ...] = ()
    services: tuple[str, ...] | None = None
    parameters: tuple[str, ...] | None = None
    origins: Collection[str] = ()
    allowlist: Allowlist | None = None
    max_pages: int = MAX_PAGES
    bags: tuple[str, ...] = ()
    granted: Container[Path] = ()

    @property
    def for_services(self) -> Access:
        """The rules for services: these rules, with the patterns for services in place of those for topics."""
        return self if self.services is None else replace(self, topics=self.services)

    @property
    def for_parameters(self) -> Access:
        """The rules for parameters: these rules, with the patterns for parameters in place of those for topics."""
        return self if self.parameters is None else replace(self, topics=self.parameters)

    def is_own_name(self, host: str | None) -> bool:
        """Return whether a Host header contains a name of this server."""
        match = _HOST_PATTERN.match(host or "")
        if match is None:
            return False
        name = (match["six"] or match["name"]).lower()
        return name in LOOPBACK or name in self.names or (self.any_address and _is_address(name))

    def is_own_page(self, origin: str | None, host: str | None) -> bool:
        """Return whether a request with these Origin and Host headers is from the server's own page or an allowed site.

        Programs other than browsers do not send an Origin header; their requests are treated as allowed.
        """
        if origin is None or origin.lower() in self.origins:
            return True
        parts = urlsplit(origin)
        return parts.scheme in ("http", "https") and parts.netloc.lower() == (host or "").lower()

    @property
    def allows_programs_from_anywhere(self) -> bool:
        """Whether programs from other sites may connect: rosbridge clients, and viewers such as Foxglove.

        These are separate web applications (https://app.foxglove.dev, a Lichtblick on another port, ``file://`` in
        their desktop versions), so their Origin is never this server's. They may connect with the right token, since
        only a person who has the link can have given them the token. On a server without a token, such pages cannot be
        distinguished from any other page, so only the allowed sites may connect. The protocol of the server's own page
        is for that page only.
        """
        return bool(self.token)

    def token_problem(self, path: str) -> str:
        """Return what is wrong with the token in a request's path, and what to do; empty if the token is right."""
        try:
            token = parse_qs(urlsplit(path).query, max_num_fields=20).get("token", [""])[0]
        except ValueError:
            token = ""
        if not self.token or hmac.compare_digest(token.encode(), self.token.encode()):
            return ""
        return f"{_STALE_TOKEN if token else _MISSING_TOKEN} {_TOKEN_HINT}"

    def may_see(self, name: str) -> bool:
        """Return whether pages may see a topic, service or parameter."""
        return not self.topics or any(fnmatchcase(name, pattern) for pattern in self.topics)

    def check_visible(self, name: str) -> None:
        """Check that pages may see a topic, service or parameter.

        Raises:
            RequestError: pages are not allowed to see the name.
        """
        if not self.may_see(name):
            raise RequestError(f"this server does not show {name} (--topics or topics_glob)")

    def visible_names(self, names: Iterable[str]) -> list[str]:
        """Return the names that pages may see."""
        return [name for name in names if self.may_see(name)]


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
