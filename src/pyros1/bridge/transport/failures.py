"""Explains to users why connections between sites fail; zenoh's own errors give neither reason nor remedy."""

from __future__ import annotations

import socket
from collections.abc import Sequence

_TIMEOUT = 3.0
_ON_TCP = ("tcp", "tls", "ws")
_IN_USE = "Address already in use"


def first_sentence(error: Exception) -> str:
    """Return the beginning of a zenoh error; the rest lists lines of zenoh's source."""
    return str(error).partition(" at ")[0].strip()[:300] or type(error).__name__


def explain_listening(error: Exception, listen: Sequence[str]) -> str:
    """Return why zenoh could not start.

    Args:
        error: zenoh's error.
        listen: the endpoints on which it was to listen.
    """
    text = str(error)
    if _IN_USE in text:
        where = " or ".join(listen)
        return f"{where} is in use by another program, perhaps another bridge: end it, or use another port"
    return first_sentence(error)


def explain_dialling(error: Exception, endpoint: str) -> str:
    """Return why a site could not be reached. To find out, this tries its port for up to three seconds.

    Args:
        error: zenoh's error.
        endpoint: where the site is expected to listen.
    """
    protocol, _, address = endpoint.partition("/")
    if protocol not in _ON_TCP:
        return first_sentence(error)
    host, _, port = address.rpartition(":")
    host = host.strip("[]")
    try:
        socket.create_connection((host, int(port)), _TIMEOUT).close()
    except OSError as reason:
        return f"cannot reach {endpoint}: {reason.strerror or reason}"
    if protocol == "tls":
        return (
            f"{endpoint} answers, but refuses this site or cannot prove its name: the keys of both must have been made "
            f"in one folder, those of the site there with the name {host}, and it must listen on tls/"
        )
    return f"{endpoint} answers, but not as a bridge: if it listens on tls/, connect to tls/, with --keys"
