"""The addresses of other sites, as eclipse-zenoh writes them: ``tcp/base.example:7447``, ``tls/[::]:7447``. No I/O."""

from __future__ import annotations

import re
from collections.abc import Iterable

from pyros1.ground.errors import Error

_PROTOCOLS = ("tcp", "tls", "quic", "udp", "ws", "unixsock-stream")
_ENCRYPTED = ("tls", "quic")
_LOOPBACK = re.compile(r"(?:localhost|127(?:\.\d{1,3}){3}|\[::1\])\Z", re.IGNORECASE)
_ADDRESS = re.compile(r"(\[[0-9A-Fa-f:.]+(?:%\w+)?\]|[A-Za-z0-9_.-]+):(\d{1,5})\Z")


class EndpointError(Error, ValueError):
    """An endpoint is not valid, or may not be used."""


def check_endpoint(text: str) -> str:
    """Return an endpoint.

    Raises:
        EndpointError: it is not one.
    """
    protocol, slash, address = text.partition("/")
    match = _ADDRESS.match(address)
    if protocol not in _PROTOCOLS or not slash:
        names = ", ".join(_PROTOCOLS)
        raise EndpointError(f"{text!r:.80} is not an endpoint: write PROTOCOL/HOST:PORT, with one of {names}")
    if protocol == "unixsock-stream":
        if not address or not re.fullmatch(r"[\w/.-]+", address):
            raise EndpointError(f"{text!r:.80} is not an endpoint: write unixsock-stream/PATH")
    elif match is None or int(match[2]) > 65535:
        raise EndpointError(f"{text!r:.80} is not an endpoint: write {protocol}/HOST:PORT")
    return text


def is_local(endpoint: str) -> bool:
    """Return whether only programs on this machine can use an endpoint to listen on."""
    protocol, _, address = endpoint.partition("/")
    return protocol == "unixsock-stream" or _LOOPBACK.match(address.rpartition(":")[0]) is not None


def check_listening(endpoints: Iterable[str], insecure: bool) -> None:
    """Refuse to listen where other machines can connect without a certificate.

    Args:
        endpoints: where a site is to listen.
        insecure: whether this is allowed nevertheless.

    Raises:
        EndpointError: it is not.
    """
    for endpoint in endpoints:
        if not (insecure or is_local(endpoint)):
            raise EndpointError(
                f"{endpoint} can be reached from other machines, and nothing keeps strangers out: they could read what "
                "is sent, and command the robot. Listen on 127.0.0.1 behind a VPN or ssh, or allow it with --insecure"
            )
