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
    elif match is not None and int(match[2]) > 65535:
        raise EndpointError(f"{text!r:.80} is not an endpoint: ports are at most 65535")
    elif match is None:
        raise EndpointError(f"{text!r:.80} is not an endpoint: write {protocol}/HOST:PORT")
    return text


def check_reachable(endpoint: str) -> None:
    """Refuse an endpoint of another site that zenoh can never connect to.

    Raises:
        EndpointError: it is encrypted and has an IPv6 address, which zenoh's TLS does not accept as the name to verify.
    """
    if _is_encrypted(endpoint) and "/[" in endpoint:
        raise EndpointError(
            f"{endpoint}: zenoh connects by TLS to host names and IPv4 addresses only. Use a host name for this IPv6 "
            "address (a line in /etc/hosts will do), and make the keys of the site that listens there with that name"
        )


def is_local(endpoint: str) -> bool:
    """Return whether only programs on this machine can reach an endpoint to listen on."""
    protocol, _, address = endpoint.partition("/")
    return protocol == "unixsock-stream" or _LOOPBACK.match(address.rpartition(":")[0]) is not None


def check_security(connect: Iterable[str], listen: Iterable[str], has_keys: bool, insecure: bool) -> None:
    """Refuse endpoints beyond this machine where sites would not have to prove who they are.

    Args:
        connect, listen: endpoints of other sites, and endpoints on which this site listens.
        has_keys: whether this site has keys, see `pyros1.bridge.transport.certificates`.
        insecure: whether unencrypted connections to and from other machines are allowed.

    Raises:
        EndpointError: an endpoint is refused.
    """
    for endpoint in (*connect, *listen):
        if _is_encrypted(endpoint) and not has_keys:
            raise EndpointError(
                f"{endpoint} needs keys: make them with `pyros1 bridge keys`, and give this site's folder with --keys"
            )
        if has_keys and not _is_encrypted(endpoint):
            raise EndpointError(f"{endpoint} cannot use the keys: use {_encrypted_form(endpoint)}, or leave --keys out")
    for endpoint in listen:
        if not (insecure or _is_encrypted(endpoint) or is_local(endpoint)):
            raise EndpointError(
                f"{endpoint} can be reached from other machines, and nothing keeps strangers out: they could read what "
                f"is sent, and command the robot. Use {_encrypted_form(endpoint)} with --keys, or allow it with "
                "--insecure"
            )
    for endpoint in connect:
        if not (insecure or _is_encrypted(endpoint) or is_local(endpoint)):
            raise EndpointError(
                f"{endpoint} is not encrypted: anyone on the way can read and change what is sent. Use "
                f"{_encrypted_form(endpoint)} with --keys, or allow it with --insecure"
            )


def _is_encrypted(endpoint: str) -> bool:
    return endpoint.partition("/")[0] in _ENCRYPTED


def _encrypted_form(endpoint: str) -> str:
    return f"tls/{endpoint.partition('/')[2]}"
