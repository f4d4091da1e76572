"""Access control: machines, the token in the link, Host and Origin, visible topics, and what may be changed.

Pure. A page of another site that is open in the same browser can send requests here, even under its own name by DNS
rebinding. But it does not know the token, and cannot send one of our names as Host.
"""

from __future__ import annotations

import hmac
import ipaddress
import re
import secrets
from collections.abc import Collection, Container, Iterable
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import parse_qs, urlsplit

if TYPE_CHECKING:
    from pyros1.net.allowlist import Allowlist

MAX_PAGES = 64
LOOPBACK = frozenset({"localhost", "127.0.0.1", "::1"})
_HOST = re.compile(r"(?:\[(?P<six>[0-9A-Fa-f:.]+)\]|(?P<name>[A-Za-z0-9._-]+))(?::(?P<port>\d{1,5}))?\Z", re.ASCII)


_STALE_TOKEN = "This link is of an earlier start of the server: pyros1 web makes a new token each time."
_MISSING_TOKEN = "This link lacks its token."
_TOKEN_HINT = (
    "Use the link that the server printed, or type pyros1 web graph, which opens it. "
    "Links stay valid if the server is started with --token and a secret of your own."
)


@dataclass(frozen=True)
class Access:
    """The access rules of one server.

    Attributes:
        token: the token that links must contain; empty for none.
        names: names under which the server may be reached, in addition to those of loopback; addresses count as names.
        any_address: whether every IP address is such a name, as for a server that listens on all interfaces.
        read_only: whether pages may not change anything.
        origins: other sites whose pages may connect, such as ``http://localhost:8000``, with the token if there is one.
        topics: patterns such as ``/camera/*`` of topics, services and parameters that pages may see; empty for all.
        allowlist: decides which machines may connect at all; None: all that can reach the interface.
        most_pages: maximum number of connected pages, programs and viewers.
        bags: folders whose bags pages may see and into which they may record, and single bags.
        granted: bags that are added later; see `pyros1.web.bags.granted_files`.
    """

    token: str = field(default_factory=lambda: secrets.token_urlsafe(16), repr=False)
    names: Collection[str] = ()
    any_address: bool = False
    read_only: bool = False
    topics: tuple[str, ...] = ()
    origins: Collection[str] = ()
    allowlist: Allowlist | None = None
    most_pages: int = MAX_PAGES
    bags: tuple[str, ...] = ()
    granted: Container[Path] = ()

    def is_our_name(self, host: str | None) -> bool:
        """Return whether a Host header names this server."""
        match = _HOST.match(host or "")
        if match is None:
            return False
        name = (match["six"] or match["name"]).lower()
        return name in LOOPBACK or name in self.names or (self.any_address and _is_address(name))

    def is_our_page(self, origin: str | None, host: str | None) -> bool:
        """Return whether an Origin header is that of our own page or of an allowed site.

        Programs other than browsers send none.
        """
        if origin is None or origin.lower() in self.origins:
            return True
        parts = urlsplit(origin)
        return parts.scheme in ("http", "https") and parts.netloc.lower() == (host or "").lower()

    @property
    def allows_programs_from_anywhere(self) -> bool:
        """Whether programs of other sites may connect: rosbridge clients, and viewers such as Foxglove.

        They are separate web applications (https://app.foxglove.dev, a Lichtblick on another port, ``file://`` in
        their desktop versions), so their Origin is never ours. With the right token they may connect: only a person
        with the link can have given it to them. Without a token, a server cannot distinguish such a page from others,
        so it admits only the allowed sites. Our own page's protocol is for that page only.
        """
        return bool(self.token)

    def token_problem(self, path: str) -> str:
        """Return the problem of the token in a path's query, and what to do; empty if it is correct."""
        try:
            given_token = parse_qs(urlsplit(path).query, max_num_fields=20).get("token", [""])[0]
        except ValueError:
            given_token = ""
        if not self.token or hmac.compare_digest(given_token.encode(), self.token.encode()):
            return ""
        return f"{_STALE_TOKEN if given_token else _MISSING_TOKEN} {_TOKEN_HINT}"

    def may_see(self, name: str) -> bool:
        """Return whether pages may see a topic, service or parameter."""
        return not self.topics or any(fnmatchcase(name, pattern) for pattern in self.topics)

    def visible(self, names: Iterable[str]) -> list[str]:
        """Return the names that pages may see."""
        return [name for name in names if self.may_see(name)]


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
